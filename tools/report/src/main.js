// The page: reads the study it holds, and puts the sections together.
import 'uplot/dist/uPlot.min.css';
import './report.css';
import {chartsSection} from './charts.js';
import {configSection, failureSection, manifestSection} from './configs.js';
import {h} from './dom.js';
import {explorerSection} from './explorer.js';
import {Choice, Study} from './model.js';
import {summarySection} from './summary.js';
import {methodChips, tableSection} from './table.js';
import {dark, onTheme, startTheme, toggleTheme} from './theme.js';

const LINKS = [['study', 'Study'], ['results', 'Results'], ['runs', 'Runs'], ['charts', 'Charts'], ['failures', 'Failures'],
  ['configs', 'Configuration'], ['manifest', 'Manifest']];

function header(study, present) {
  const theme = h('button', {type: 'button', class: 'theme', onclick: toggleTheme});
  const name = () => {
    theme.textContent = dark() ? 'light' : 'dark';
    theme.setAttribute('aria-label', `${theme.textContent} colours`);
  };
  onTheme(name);
  name();
  return h('header', {class: 'top'}, h('a', {class: 'brand', href: '#study'}, 'AS-LIO Lab'),
    h('nav', {'aria-label': 'sections'}, LINKS.filter(([id]) => present.has(id)).map(([id, text]) => h('a', {href: `#${id}`}, text))), theme);
}

function start() {
  const study = new Study(JSON.parse(document.getElementById('study').textContent));
  const first = study.recordings.find((group) => group.runs.some((run) => run.series)) ?? study.recordings[0];
  const choice = new Choice({
    metric: study.metrics[0] ?? study.tables[0]?.metric, hidden: new Set(), recording: first?.key, focus: null, time: 0, logBoxes: false, theme: 0,
  });
  startTheme();
  onTheme(() => choice.set({theme: choice.get('theme') + 1}));
  // A study that has just begun has no runs to show.
  const sections = !study.runs.length ? [summarySection(study, choice)] : [
    summarySection(study, choice), tableSection(study, choice), explorerSection(study, choice, methodChips(study, choice)),
    chartsSection(study, choice), failureSection(study), configSection(study), manifestSection(study),
  ].filter(Boolean);
  document.getElementById('report').append(
    header(study, new Set(sections.map((s) => s.id))), h('main', null, sections),
    h('footer', null, `${study.made_by}${study.revision ? `, revision ${study.revision}` : ''}`));
  document.documentElement.dataset.ready = 'true';
}

start();
