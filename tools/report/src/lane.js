// What state each run was in, below the time axis: a strip per run, empty where all was well.
import {h} from './dom.js';
import {brief} from './model.js';

const LOST = new Set(['alarm', 'lost']);
const WORDS = {
  alarm: 'the monitor raised its alarm', lost: 'lost', degenerate: 'the points left a direction open', few_matches: 'too few matches',
  not_converged: 'the registration did not converge', non_finite: 'no finite result', initialising: 'initialising', degraded: 'degraded',
};
/** A stretch is drawn at least so wide [px]: an alarm may last for one update. */
const LEAST = 3;

export class Lane {
  constructor() {
    this.element = h('figure', {'aria-label': 'State of the runs', class: 'lane'});
  }

  /** runs: [{name, colour, stretches: [[begin, end, state]]}]. */
  show(runs) {
    this.bars = [];
    const rows = runs.map(({name, colour, stretches}) => {
      const bar = h('div', {class: 'bar', role: 'img', 'aria-label': `${name}: ${summaryOf(stretches)}`},
        stretches.map(([begin, end, state]) => {
          const mark = h('i', {class: LOST.has(state) ? 'lost' : 'weak', title: `${name}, ${brief(begin)} to ${brief(end)} s: ${WORDS[state] ?? state}`});
          this.bars.push({mark, begin, end});
          return mark;
        }));
      bar.style.setProperty('--c', colour);
      return bar;
    });
    this.element.replaceChildren(h('div', {class: 'plot-head'}, h('strong', null, 'State'),
      h('span', {class: 'note'}, h('i', {class: 'weak'}), ' weak or refused ', h('i', {class: 'lost'}), ' alarm or lost')), h('div', {class: 'rows'}, rows));
    this.element.hidden = !runs.length;
  }

  /** Under the drawing area of a chart: its left edge and width [px], and the time that it shows. */
  place(left, width, [low, high]) {
    const rows = this.element.lastChild;
    if (!rows) return;
    rows.style.marginLeft = `${left}px`;
    rows.style.width = `${width}px`;
    const at = (t) => (width * (t - low)) / (high - low);
    for (const {mark, begin, end} of this.bars) {
      const from = Math.max(at(begin), 0), to = Math.min(Math.max(at(end), at(begin) + LEAST), width);
      mark.hidden = to <= from;
      mark.style.left = `${from}px`;
      mark.style.width = `${to - from}px`;
    }
  }
}

function summaryOf(stretches) {
  if (!stretches.length) return 'well all the time';
  return stretches.map(([begin, end, state]) => `${state} from ${brief(begin)} to ${brief(end)} s`).join(', ');
}
