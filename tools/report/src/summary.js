// What the study asks, and how the methods stand, in one look.
import {h, scroller, section} from './dom.js';
import {markdown} from './markdown.js';
import {brief, heading, ratioOf, significant, strengthOf} from './model.js';
import {colourOf} from './theme.js';

function questionCards(study) {
  const card = (title, text, kind) => text && h('div', {class: `card ${kind}`}, h('h3', null, title), h('p', null, text));
  const cards = [card('Question', study.question, 'question'), card('Prediction', study.prediction, ''), card('Rule', study.rule, '')];
  return cards.some(Boolean) && h('div', {class: 'cards'}, cards);
}

const OUTCOMES = {holds: ['good', 'holds'], 'does not hold': ['bad', 'does not hold'], 'not decided': ['open', 'not decided']};

const claimsOf = (text) => [...text.matchAll(/^- ([^\n]+): \*\*(holds|does not hold|not decided)( so far)?\*\*( \([^\n]*\))?\s*$/gm)];

const claimList = (claims) => h('ul', {class: 'claims'}, claims.map(([, text, outcome, soFar, open]) => h('li', null,
  h('span', {class: `badge ${OUTCOMES[outcome][0]}`}, OUTCOMES[outcome][1] + (soFar ?? '')), h('span', null, text + (open ?? '')))));

/** What the study has judged by itself. */
function expectationCard(study) {
  const claims = claimsOf((study.expectation ?? []).map((rule) => `- ${rule}`).join('\n'));
  return claims.length > 0 && h('div', {class: 'card verdict'}, h('h3', null, 'Expectation'), claimList(claims));
}

/** The claims of the verdict with their outcomes; the whole of it on demand. */
function verdictCard(study) {
  if (!study.verdict) return null;
  const claims = claimsOf(study.verdict);
  return h('div', {class: 'card verdict'}, h('h3', null, 'Verdict'),
    claims.length > 0 && claimList(claims),
    h('details', {open: claims.length === 0}, h('summary', null, 'the whole verdict'), h('div', {class: 'prose'}, markdown(study.verdict))));
}

/** Per method: how often best, the typical ratio to the baseline, what failed, what it costs. */
function standing(study, metric) {
  const table = study.table(metric);
  const cpu = study.table('cpu_s_per_s');
  return study.methods.map((name, m) => {
    const cells = table.lines.map((line) => line.cells[m]);
    const runs = study.runs.filter((run) => run.method === name);
    const comparison = table.comparisons.find((c) => c.method === m);
    const costs = cpu && cpu.metric === 'cpu_s_per_s' ? cpu.lines.map((line) => line.cells[m].median).filter(Number.isFinite) : [];
    costs.sort((a, b) => a - b);
    return {
      name: study.labels[m], m, comparison,
      best: cells.filter((cell) => cell.rank === 1).length,
      second: cells.filter((cell) => cell.rank === 2).length,
      bad: runs.filter((run) => !run.good).length, runs: runs.length,
      cost: costs.length ? costs[Math.floor(costs.length / 2)] : null,
      baseline: study.baselines.includes(m),
      only: cells.length === 1 ? cells[0] : null,
    };
  });
}

function winsBar(line, sequences) {
  const width = (count) => ({width: `${(100 * count) / Math.max(sequences, 1)}%`});
  return h('div', {class: 'wins', title: `best on ${line.best}, second on ${line.second} of ${sequences} sequences`},
    h('span', {class: 'first', style: width(line.best)}), h('span', {class: 'second', style: width(line.second)}));
}

const ratioText = (ratio) => (ratio === undefined || ratio === null ? '' : ratio === 'x' ? 'x' : ratioOf(ratio));

function standingTable(study, metric) {
  const table = study.table(metric);
  const lines = standing(study, metric);
  const anyRatio = lines.some((line) => line.comparison);
  const ranked = table.smaller && lines.length > 1;
  const head = ['Method', ranked ? `Rank over ${study.sequences.length} ${study.sequences.length === 1 ? 'sequence' : 'sequences'}` : null,
    anyRatio ? 'Ratio to baseline' : null, anyRatio ? 'Pairs won / lost' : null, 'CPU per s of data', 'Failed'];
  return scroller(h('table', {class: 'plain standing'},
    h('thead', null, h('tr', null, head.filter(Boolean).map((text) => h('th', {scope: 'col'}, text)))),
    h('tbody', null, lines.map((line) => h('tr', null,
      h('th', {scope: 'row'}, h('span', {class: 'swatch', style: {'--c': colourOf(line.m)}, 'data-method': line.m}), line.name,
        line.baseline && h('span', {class: 'tag'}, 'baseline')),
      ranked && h('td', null, winsBar(line, study.sequences.length), h('span', {class: 'count'}, rankWords(line))),
      anyRatio && h('td', ratioLook(line.comparison), line.comparison ? ratioText(line.comparison.ratio) : ''),
      anyRatio && h('td', null, line.comparison ? `${line.comparison.pairs[0]} / ${line.comparison.pairs[1]}` : ''),
      h('td', null, line.cost === null ? '' : `${brief(line.cost)} s`),
      h('td', {class: line.bad ? 'bad' : ''}, line.bad ? `${line.bad} of ${line.runs}` : '0'))))));
}

/** "best on 2, second on 1". */
function rankWords(line) {
  const words = [line.best && `best on ${line.best}`, line.second && `second on ${line.second}`].filter(Boolean);
  return words.join(', ') || 'neither best nor second';
}

/** Colour only for what is more than chance, and the stronger the larger it is. */
function ratioLook(comparison) {
  if (!comparison || typeof comparison.ratio !== 'number') return {};
  if (!significant(comparison)) return {title: 'no difference beyond chance, or too few pairs: p (Holm) is not below 0.05'};
  return {class: comparison.ratio < 1 ? 'better' : 'worse', title: 'p (Holm) is below 0.05',
    style: {'--strength': `${Math.round(35 + 65 * strengthOf(comparison.ratio))}%`}};
}

function tiles(study) {
  const bad = study.runs.filter((run) => !run.good);
  const degraded = study.runs.filter((run) => run.status === 'degraded').length;
  const tile = (value, text, kind = '') => h('div', {class: `tile ${kind}`}, h('strong', null, value), h('span', null, text));
  const seeds = new Set(study.runs.map((run) => run.seed).filter(Boolean)).size;
  const way = study.runs.reduce((sum, run) => sum + (study.figure(run, 'path_length_m') ?? 0), 0) / 1000;
  return h('div', {class: 'tiles'},
    tile(`${study.runs.length}${study.planned > study.runs.length ? ` of ${study.planned}` : ''}`, 'runs', study.planned > study.runs.length ? 'open' : ''),
    tile(String(study.sequences.length), study.sequences.length === 1 ? 'sequence' : 'sequences'),
    seeds > 0 && tile(String(seeds), seeds === 1 ? 'seed' : 'seeds'),
    tile(String(study.methods.length), study.methods.length === 1 ? 'method' : 'methods'),
    way > 0 && (way < 1 ? tile((1000 * way).toFixed(0), 'm travelled') : tile(way.toFixed(1), 'km travelled')),
    tile(String(bad.length), 'failed or diverged', bad.length ? 'bad' : 'good'),
    degraded > 0 && tile(String(degraded), 'degraded'));
}

function leftOut(study) {
  return study.left_out?.length > 0 && h('div', {class: 'card warning'}, h('h3', null, 'Left out'),
    h('p', null, 'The page exceeds the limit of aslio report --limit. It leaves out:'),
    h('ul', null, study.left_out.map((text) => h('li', null, text))));
}

function incomplete(study) {
  return study.incomplete && h('div', {class: 'card warning'}, h('h3', null, 'Incomplete'), h('p', null, study.incomplete));
}

function warnings(study) {
  return study.identical?.length > 0 && h('div', {class: 'card warning'}, h('h3', null, 'Identical results'),
    h('ul', null, study.identical.map((text) => h('li', null, text))));
}

export function summarySection(study, choice) {
  const place = h('div');
  const draw = () => {
    const table = study.table(choice.get('metric'));
    place.replaceChildren(...[h('h3', null, `Standing by ${heading(table)}`), standingTable(study, choice.get('metric')),
      table.comparisons.length > 0 && h('p', {class: 'note'}, 'A ratio has a colour where p (Holm) is below 0.05.')].filter(Boolean));
  };
  if (study.tables.length) {
    choice.on(['metric', 'theme'], draw);
    draw();
  }
  return section('study', study.name, null, questionCards(study), expectationCard(study), verdictCard(study), tiles(study), incomplete(study), warnings(study), leftOut(study), place);
}

