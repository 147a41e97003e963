"""Charts over one horizontal axis as SVG text: panels with lines above each other, and coloured spans behind them."""
import math

from numerics import np

WIDTH, LEFT, RIGHT, PANEL, GAP, TOP, BOTTOM = 1200, 70, 20, 150, 26, 34, 44
COLOURS = ("#1f4e9c", "#c2410c", "#0f766e", "#7c3aed", "#4b5563", "#b91c1c")


def escaped(text):
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


def ticks(low, high, most):
    """Round values in [low, high], at most `most`."""
    if not high > low:
        return [low]
    step = 10.0 ** math.floor(math.log10((high - low) / most))
    while (high - low) / step > most:
        step *= 2.5 if round(step / 10.0 ** math.floor(math.log10(step) + 1e-9)) == 2 else 2
    return [k * step for k in range(math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9) + 1)]


class Panel:
    """Lines share a vertical axis, which spans their values unless `limits` says otherwise."""

    def __init__(self, title, limits=None):
        self.title, self.limits, self.lines = title, limits, []

    def line(self, label, t, values):
        """Values that are not finite leave a gap."""
        self.lines.append((label, np.asarray(t, dtype=float), np.asarray(values, dtype=float)))
        return self

    def extent(self):
        if self.limits:
            return self.limits
        values = np.concatenate([v[np.isfinite(v)] for _, _, v in self.lines] or [np.zeros(0)])
        low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
        margin = 0.05 * (high - low) or 1.0
        return low - margin, high + margin


def visible(t, values, x):
    """Indices of what a picture can show: of more than two values in a column of two pixels, the lowest and the highest."""
    column = np.floor(np.array([x(at) for at in t]) / 2)
    kept = []
    for indices in np.split(np.arange(len(t)), np.flatnonzero(np.diff(column)) + 1):
        if len(indices) > 2 and np.all(np.isfinite(values[indices])):
            indices = sorted({indices[np.argmin(values[indices])], indices[np.argmax(values[indices])]})
        kept.extend(indices)
    return kept


def strokes(t, values, x, y):
    """The `d` of a path, broken where a value is missing."""
    shown = visible(t, values, x)
    t, values = t[shown], values[shown]
    words, pen = [], "M"
    for at, value in zip(t, values):
        if math.isfinite(value):
            words.append(f"{pen}{x(at):.1f} {y(value):.1f}")
            pen = "L"
        else:
            pen = "M"
    return "".join(words)


def draw_panel(panel, top, x, span):
    low, high = panel.extent()

    def y(value):
        share = (min(max(value, low), high) - low) / (high - low)
        return top + PANEL * (1 - share)

    out = [f'<rect x="{LEFT}" y="{top}" width="{WIDTH - LEFT - RIGHT}" height="{PANEL}" fill="none" stroke="#9ca3af"/>']
    for tick in ticks(low, high, 5):
        out.append(f'<line x1="{LEFT}" x2="{WIDTH - RIGHT}" y1="{y(tick):.1f}" y2="{y(tick):.1f}" stroke="#e5e7eb"/>')
        out.append(f'<text x="{LEFT - 6}" y="{y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>')
    right = WIDTH - RIGHT
    for number, (label, t, values) in reversed(list(enumerate(panel.lines))):
        colour, inside = COLOURS[number % len(COLOURS)], (t >= span[0]) & (t <= span[1])
        out.append(f'<path d="{strokes(t[inside], values[inside], x, y)}" fill="none" stroke="{colour}" stroke-width="1.2"/>')
        out.append(f'<text x="{right}" y="{top - 7}" text-anchor="end" fill="{colour}">{escaped(label)}</text>')
        right -= 16 + 7 * len(label)
    out.append(f'<text x="{LEFT}" y="{top - 7}" font-weight="bold">{escaped(panel.title)}</text>')
    return out


def chart(title, panels, span, axis, spans=()):
    """`span`: (begin, end) of the horizontal axis, named `axis`; `spans`: (begin, end, colour) behind all panels."""
    height = TOP + len(panels) * (PANEL + GAP) + BOTTOM

    def x(at):
        return LEFT + (WIDTH - LEFT - RIGHT) * (at - span[0]) / (span[1] - span[0])

    out = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height}" viewBox="0 0 {WIDTH} {height}" '
           'font-family="sans-serif" font-size="12">', '<rect width="100%" height="100%" fill="white"/>',
           f'<text x="{LEFT}" y="20" font-size="15">{escaped(title)}</text>']
    for number, panel in enumerate(panels):
        top = TOP + GAP + number * (PANEL + GAP)
        for begin, end, colour in spans:
            left, right = x(max(begin, span[0])), x(min(end, span[1]))
            if right > left:
                out.append(f'<rect x="{left:.1f}" y="{top}" width="{max(right - left, 1.5):.1f}" height="{PANEL}" '
                           f'fill="{colour}" fill-opacity="0.3"/>')
        out += draw_panel(panel, top, x, span)
    bottom = TOP + len(panels) * (PANEL + GAP)
    for tick in ticks(*span, 12):
        out.append(f'<text x="{x(tick):.1f}" y="{bottom + 16}" text-anchor="middle">{tick:g}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{bottom + 34}" text-anchor="middle">{escaped(axis)}</text>')
    return "\n".join(out + ["</svg>"]) + "\n"
