// Everything over one time axis: the same cursor and the same zoom for all charts.
import uPlot from 'uplot';
import {h} from './dom.js';
import {Lane} from './lane.js';
import {brief} from './model.js';
import {ink} from './theme.js';
import {valueAt} from './value_at.js';

export const CHANNELS = [
  ['sod', 'Overlap degree', ''],
  ['rate_hz', 'Update rate', 'Hz'],
  ['gyro_deg_s', 'Turn rate', 'deg/s'],
  ['error_cm', 'Position error', 'mm'],
  ['matches', 'Matches', ''],
  ['residual_cm', 'Residual RMS', 'mm'],
  ['weakest', 'Weakest direction', '1/m\u00b2'],
  ['iterations', 'Iterations', ''],
  ['cpu_ms', 'CPU per update', 'ms'],
];
const STEPS = new Set(['rate_hz', 'iterations']);
/** In the file in centimetres; for people as the tables are: mm where all of a chart is below 0.1 m, else m. */
const LENGTHS = new Set(['error_cm', 'residual_cm']);
const LOGARITHMIC = new Set(['weakest']);
/** Peaks of single updates, as of a window that the end cuts short, do not set the scale of these. */
const PEAKY = new Set(['rate_hz', 'cpu_ms']);
const AXIS = 52;

const powersOnly = (_, splits) => splits.map((v) => (Math.abs(Math.log10(v) % 1) < 1e-9 ? v : null));

/** Scale of y up to what all but a few samples stay below. */
function bound(lines) {
  const tops = lines.map(({channel}) => {
    const sorted = channel.v.filter(Number.isFinite).sort();
    return sorted[Math.floor(0.995 * (sorted.length - 1))];
  });
  return [0, 1.25 * Math.max(...tops, 1e-9)];
}

/** Lines of a chart in the unit that suits them, and that unit. */
function inUnit(name, unit, lines) {
  if (!LENGTHS.has(name)) return [lines, unit];
  const largest = Math.max(...lines.map(({channel}) => channel.v.reduce((most, v) => (v > most ? v : most), 0)));
  const [scale, chosen] = largest < 10 ? [10, 'mm'] : [0.01, 'm'];
  return [lines.map((line) => ({...line, channel: {...line.channel, v: line.channel.v.map((v) => scale * v), unit: scale * line.channel.unit}})), chosen];
}

/** Samples between two breaks, of which no line tells. */
function lonely(plot, series) {
  const values = plot.data[series], found = [];
  let before = null, last = -1, alone = false;
  values.forEach((v, i) => {
    if (v === undefined) return;
    if (v === null) {
      if (alone) found.push(last);
      alone = false;
    } else {
      alone = before === null;
      last = i;
    }
    before = v;
  });
  if (alone) found.push(last);
  return found;
}

export class Timeline {
  constructor(choice) {
    this.choice = choice;
    this.element = h('div', {class: 'timeline'});
    this.plots = [];
    this.range = null;
    this.lane = new Lane();
    new ResizeObserver(() => this.resize()).observe(this.element);
  }

  /** lines: by channel, [{name, colour, channel, dash}]; states: as Lane.show takes them; range: [begin, end]. */
  show(lines, states, range) {
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    this.full = range;
    this.range ??= range;
    const present = CHANNELS.filter(([name]) => lines[name]?.length);
    this.element.replaceChildren(...present.map(([name, title, usual], index) => {
      const [drawn, unit] = inUnit(name, usual, lines[name]);
      const readings = h('span', {class: 'readings'});
      const place = h('div', {class: 'plot'});
      const head = h('div', {class: 'plot-head'}, h('strong', null, title), unit && h('span', {class: 'unit'}, ` ${unit}`), readings);
      queueMicrotask(() => this.plot(place, readings, name, drawn, index === present.length - 1));
      return h('figure', {'aria-label': title}, head, place);
    }));
    this.lane.show(states);
    if (present.length) this.element.append(this.lane.element);
    else this.element.append(h('p', {class: 'note'}, 'No run of this recording has left a course.'));
  }

  plot(place, readings, name, lines, last) {
    const logarithmic = LOGARITHMIC.has(name) && lines.some(({channel}) => channel.v.some((v) => v > 0));
    // null breaks a line. What join() has to fill in, since another run has a sample there, is undefined, and breaks none.
    // On a logarithmic scale what was rounded to 0 is half of what it was rounded by.
    const drawn = (v, unit) => (!Number.isFinite(v) ? null : logarithmic ? Math.max(v, unit / 2) : v);
    const joined = uPlot.join(lines.map(({channel}) => [channel.t, Array.from(channel.v, (v) => drawn(v, channel.unit))]));
    const series = lines.map((line) => ({
      label: line.name, stroke: line.colour, width: line.dash ? 1 : 1.3, spanGaps: false, points: {show: true, size: 3, filter: lonely}, dash: line.dash,
      paths: STEPS.has(name) ? uPlot.paths.stepped({align: -1}) : undefined,
    }));
    const grid = {stroke: ink('line'), width: 1};
    const text = {stroke: ink('muted'), font: '11px system-ui, sans-serif', ticks: {stroke: ink('line'), size: 4}};
    const plot = new uPlot({
      width: this.width(), height: last ? 118 : 92, padding: [6, 10, last ? 0 : 4, 0], legend: {show: false},
      // Its own dots would sit on samples, at other times than the cursor and than each other.
      cursor: {sync: {key: 'aslio'}, drag: {x: true, y: false}, points: {show: false}, y: false},
      scales: {x: {time: false, min: this.range[0], max: this.range[1]}, y: {distr: logarithmic ? 3 : 1, ...(PEAKY.has(name) && {range: bound(lines)})}},
      axes: [{...text, grid, show: true, size: last ? 26 : 0, values: last ? (_, v) => v.map((t) => `${brief(t)}${t ? '' : ' s'}`) : () => []},
        {...text, grid: logarithmic ? {...grid, filter: powersOnly} : grid, size: AXIS, space: 24, ...(logarithmic && {filter: powersOnly, ticks: {...text.ticks, filter: powersOnly}}), values: (_, v) => v.map((y) => (y === null ? '' : brief(y)))}],
      series: [{}, ...series],
      hooks: {
        setCursor: [(u) => this.read(u, readings)],
        setScale: [(u, key) => key === 'x' && this.zoom(u)],
        ready: [() => last && this.placeLane()],
        setSize: [() => last && this.placeLane()],
      },
    }, joined, place);
    plot.over.addEventListener('click', () => this.choice.set({time: plot.posToVal(plot.cursor.left, 'x')}));
    plot.over.addEventListener('dblclick', () => this.reset());
    const cursor = h('div', {class: 'now'});
    plot.over.append(cursor);
    plot.now = cursor;
    plot.lines = lines;
    plot.at = (line, time) => valueAt(line.channel, time, STEPS.has(name), logarithmic);
    plot.dots = lines.map((line) => h('i', {class: 'dot', hidden: true, style: {background: line.colour}}));
    plot.over.append(...plot.dots);
    this.plots.push(plot);
    this.place(plot);

  }

  /** The lines at the cursor: the values beside the title, and a dot on each line, all at one and the same time. */
  read(plot, readings) {
    const {left} = plot.cursor;
    if (!plot.dots) return;
    const inside = left !== null && left !== undefined && left >= 0;
    const time = inside ? plot.posToVal(left, 'x') : NaN;
    const values = plot.lines.map((line) => plot.at(line, time));
    plot.dots.forEach((dot, i) => {
      dot.hidden = !Number.isFinite(values[i]);
      if (dot.hidden) return;
      dot.style.left = `${left}px`;
      dot.style.top = `${plot.valToPos(values[i], 'y')}px`;
    });
    readings.replaceChildren(...(inside ? [h('span', {class: 'unit'}, `${time.toFixed(2)} s`),
      ...plot.lines.map((line, i) => h('span', {style: {color: line.colour}}, brief(values[i])))] : []));
  }

  zoom(plot) {
    const {min, max} = plot.scales.x;
    if (this.zooming || min === null || min === undefined) return;
    if (this.range[0] === min && this.range[1] === max) return;
    this.zooming = true;
    this.range = [min, max];
    for (const other of this.plots) if (other !== plot) other.setScale('x', {min, max});
    this.zooming = false;
    for (const each of this.plots) this.place(each);
    this.placeLane();
  }

  placeLane() {
    const over = this.plots.at(-1)?.over;
    if (!over) return;
    const left = over.getBoundingClientRect().left - this.lane.element.getBoundingClientRect().left;
    this.lane.place(left, over.clientWidth, this.range);
  }

  reset() {
    this.range = this.full;
    for (const plot of this.plots) plot.setScale('x', {min: this.full[0], max: this.full[1]});
  }

  seek() {
    for (const plot of this.plots) this.place(plot);
  }

  /** The line of the chosen time. */
  place(plot) {
    const time = this.choice.get('time'), [low, high] = this.range;
    plot.now.hidden = !(time >= low && time <= high);
    plot.now.style.left = `${(100 * (time - low)) / (high - low)}%`;
  }

  width() {
    return Math.max(this.element.clientWidth, 200);
  }

  resize() {
    const width = this.width();
    for (const plot of this.plots) if (plot.width !== width) plot.setSize({width, height: plot.height});
  }
}
