// The results: sortable, filtered, and every cell opens its runs.
import {h, s, scroller, section, segmented, select} from './dom.js';
import {heading, ratioOf, shown} from './model.js';
import {colourOf} from './theme.js';

const MARKS = {diverged: ['-', 'severe divergence midway'], failed: ['x', 'total failure'], absent: ['', 'no figure']};

function valueOf(cell) {
  if (cell.mark === 'value') return cell.median;
  return cell.mark === 'absent' ? Infinity : Number.MAX_VALUE;
}

/** Smallest to largest with the median, on the scale of the line. */
function rangeBar(cell, largest, colour) {
  if (!cell.range || !(largest > 0)) return null;
  const at = (value) => `${Math.max(0, Math.min(100, (100 * value) / largest))}%`;
  return s('svg', {class: 'range', 'aria-hidden': 'true', width: '100%', height: '6'},
    s('line', {x1: at(cell.range[0]), x2: at(cell.range[1]), y1: 3, y2: 3, stroke: colour, 'stroke-width': 2, opacity: 0.55}),
    cell.mark === 'value' && s('circle', {cx: at(cell.median), cy: 3, r: 2.6, fill: colour}));
}

function cellText(table, cell) {
  const mark = MARKS[cell.mark];
  const failures = cell.runs > 1 && [cell.failed && `${cell.failed}x`, cell.diverged && `${cell.diverged}-`].filter(Boolean).join(' ');
  return [
    h('span', {class: `value rank${cell.rank ?? 0}`}, mark ? mark[0] : shown(table, cell.median)),
    cell.range && cell.recordings > 1 && h('span', {class: 'spread'}, `${shown(table, cell.range[0])}\u2013${shown(table, cell.range[1])}`),
    failures && h('span', {class: 'failures', title: `${cell.failed ?? 0} failed, ${cell.diverged ?? 0} diverged of ${cell.runs}`}, failures),
  ];
}

export class ResultsTable {
  constructor(study, choice) {
    this.study = study;
    this.choice = choice;
    this.sort = {method: null, descending: false};
    this.filter = '';
    this.open = null;
    this.place = scroller();
    this.comparison = h('div');
    choice.on(['metric', 'hidden', 'theme'], () => this.draw());
    this.draw();
  }

  get table() {
    return this.study.table(this.choice.get('metric'));
  }

  methods() {
    return this.study.methods.map((_, m) => m).filter((m) => !this.choice.get('hidden').has(m));
  }

  lines() {
    const words = this.filter.toLowerCase();
    const lines = this.table.lines.filter((line) => line.sequence.toLowerCase().includes(words));
    const {method, descending} = this.sort;
    if (method !== null) {
      const sign = descending ? -1 : 1;
      lines.sort((a, b) => sign * (method < 0 ? a.sequence.localeCompare(b.sequence, undefined, {numeric: true})
        : valueOf(a.cells[method]) - valueOf(b.cells[method])));
    }
    return lines;
  }

  sortBy(method) {
    this.sort = {method, descending: this.sort.method === method && !this.sort.descending};
    this.draw();
    this.place.querySelector(`button[data-sort="${method}"]`)?.focus();
  }

  header(m, text) {
    const active = this.sort.method === m;
    const order = active ? (this.sort.descending ? 'descending' : 'ascending') : 'none';
    return h('th', {scope: 'col', 'aria-sort': order},
      h('button', {type: 'button', class: 'sort', 'data-sort': m, onclick: () => this.sortBy(m), title: 'sort by this column'},
        m >= 0 && h('span', {class: 'swatch', style: {'--c': colourOf(m)}}), text,
        h('span', {class: 'arrow', 'aria-hidden': 'true'}, active ? (this.sort.descending ? '\u2193' : '\u2191') : '')));
  }

  draw() {
    const methods = this.methods();
    const body = h('tbody');
    for (const line of this.lines()) {
      const largest = Math.max(...methods.map((m) => line.cells[m].range?.[1] ?? 0));
      body.append(h('tr', null, h('th', {scope: 'row'}, line.sequence), methods.map((m) => this.cell(line, m, largest))));
      if (this.open && this.open.sequence === line.sequence && methods.includes(this.open.method)) {
        body.append(h('tr', {class: 'detail'}, h('td', {colspan: methods.length + 1}, this.runs())));
      }
    }
    this.place.replaceChildren(h('table', {class: 'results'},
      h('caption', null, heading(this.table)),
      h('thead', null, h('tr', null, this.header(-1, 'sequence'), methods.map((m) => this.header(m, this.study.labels[m])))), body));
    this.comparison.replaceChildren(...this.comparisons());
  }

  cell(line, m, largest) {
    const cell = line.cells[m];
    const open = this.open && this.open.sequence === line.sequence && this.open.method === m;
    const toggle = () => {
      this.open = open ? null : {sequence: line.sequence, method: m};
      this.draw();
      this.place.querySelector(`button[data-cell="${m}"][aria-expanded="${!open}"]`)?.focus();
    };
    return h('td', {class: `mark-${cell.mark}`}, h('button', {
      type: 'button', class: 'cell', 'data-cell': m, 'aria-expanded': String(Boolean(open)), onclick: toggle,
      title: `${cell.runs} runs of ${this.study.labels[m]} on ${line.sequence}`,
    }, cellText(this.table, cell), rangeBar(cell, largest, colourOf(m))));
  }

  /** The runs behind the open cell. */
  runs() {
    const {study, open} = this;
    const figures = [...new Set([this.table.metric, ...study.metrics, 'rate_hz', 'cpu_s_per_s', 'peak_rss_mb'])].filter((name) => study.figures.includes(name));
    const tables = figures.map((name) => study.table(name));
    return h('div', {class: 'runs'}, scroller(h('table', {class: 'plain'},
      h('thead', null, h('tr', null, ['run', 'status', ...tables.map(heading), ''].map((text, i) => h('th', {scope: 'col', class: i < 2 ? 'left' : ''}, text)))),
      h('tbody', null, study.runsOf(open.sequence, study.methods[open.method]).map((run) => h('tr', null,
        h('th', {scope: 'row'}, run.order && run.order !== '0' ? `${run.data}, order ${run.order}` : run.data),
        h('td', {class: 'left'}, h('span', {class: `badge ${run.good ? (run.status === 'ok' ? 'good' : 'open') : 'bad'}`}, run.status),
          run.reason && h('span', {class: 'reason'}, run.reason)),
        tables.map((table) => h('td', null, shown(table, study.figure(run, table.metric)))),
        h('td', null, run.series
          ? h('button', {type: 'button', class: 'small', onclick: () => this.show(run)}, 'look at it')
          : h('span', {class: 'note'}, 'no course'))))))));
  }

  show(run) {
    const recording = this.study.recordings.find((group) => group.runs.includes(run));
    const hidden = new Set(this.choice.get('hidden'));
    hidden.delete(this.study.methods.indexOf(run.method));
    this.choice.set({recording: recording.key, focus: run.method, hidden});
    document.getElementById('runs').scrollIntoView({behavior: 'smooth'});
  }

  comparisons() {
    const lines = this.table.comparisons;
    if (!lines.length) return [];
    const tally = (t) => `${t[0]} / ${t[1]} / ${t[2]}`;
    const name = (m) => this.study.labels[m];
    const more = lines[0].more.map(([title]) => title);
    return [h('h3', null, `${this.table.title} against the baseline`), scroller(h('table', {class: 'plain'},
      h('thead', null, h('tr', null, ['method', 'baseline', 'sequences won / lost / tied', 'pairs won / lost / tied', 'median ratio', ...more]
        .map((text) => h('th', {scope: 'col'}, text)))),
      h('tbody', null, lines.map((line) => h('tr', null, h('th', {scope: 'row'}, name(line.method)), h('td', null, name(line.baseline)),
        h('td', null, tally(line.sequences)), h('td', null, tally(line.pairs)),
        h('td', null, typeof line.ratio === 'number' ? ratioOf(line.ratio) : line.ratio ?? ''), line.more.map(([, text]) => h('td', null, text)))))))];
  }
}

/** A button that shows a text to take away. */
function copyButton(label, text) {
  return h('button', {type: 'button', onclick: () => {
    const area = h('textarea', {readonly: true, rows: 24, cols: 90, 'aria-label': label});
    area.value = text;
    const said = h('output', {class: 'note'});
    const copy = async () => {
      // A browser may withhold the clipboard from a file; the old way then works.
      const kept = await navigator.clipboard?.writeText(text).then(() => true, () => false);
      area.focus();
      area.select();
      said.value = kept || document.execCommand('copy') ? 'copied' : 'select it and press Ctrl+C';
    };
    const dialog = h('dialog', {'aria-label': label}, area, h('form', {method: 'dialog', class: 'tools'},
      h('button', {type: 'button', class: 'copy', onclick: copy}, 'copy'), h('button', null, 'close'), said));
    dialog.addEventListener('close', () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
    area.focus();
    area.select();
  }}, label);
}

export function methodChips(study, choice) {
  const place = h('div', {class: 'chips', role: 'group', 'aria-label': 'methods shown'});
  const draw = () => {
    const hidden = choice.get('hidden');
    place.replaceChildren(...study.labels.map((name, m) => h('button', {
      type: 'button', class: 'chip', 'aria-pressed': String(!hidden.has(m)), style: {'--c': colourOf(m)},
      onclick: () => {
        const next = new Set(hidden);
        if (!next.delete(m)) next.add(m);
        if (next.size < study.methods.length) choice.set({hidden: next});
      },
    }, h('span', {class: 'swatch', style: {'--c': colourOf(m)}}), name)));
  };
  choice.on(['hidden', 'theme'], draw);
  draw();
  return place;
}

export function tableSection(study, choice) {
  const results = new ResultsTable(study, choice);
  const main = study.metrics.map((name) => [name, study.table(name).title]);
  const rest = study.tables.filter((table) => !study.metrics.includes(table.metric)).map((table) => [table.metric, table.title]);
  const setMetric = (metric) => {
    choice.set({metric});
    for (const button of buttons.children) button.setAttribute('aria-pressed', String(button.dataset.value === metric));
    more.value = rest.some(([name]) => name === metric) ? metric : '';
  };
  const buttons = segmented('metric', main, choice.get('metric'), setMetric);
  const more = select('more figures', [['', 'more figures'], ...rest], '', (metric) => metric && setMetric(metric));
  const filter = h('input', {
    type: 'search', placeholder: 'filter sequences', 'aria-label': 'filter sequences',
    oninput: (event) => { results.filter = event.target.value; results.draw(); },
  });
  return section('results', 'Results',
    'Median over seeds with smallest and largest; the best of a line is bold, the second underlined. A run that failed or '
    + 'diverged counts as worse than any figure: x is a total failure, - a severe divergence midway, 2x two of either kind '
    + 'among the runs of a cell. A cell opens its runs.',
    h('div', {class: 'tools'}, buttons, rest.length > 0 && more, filter,
      h('span', {class: 'push'}), copyButton('LaTeX', study.latex), copyButton('Markdown', study.markdown)),
    methodChips(study, choice), results.place, results.comparison);
}
