// How the resolved pipelines of two methods differ, and what was run.
import {h, scroller, section, select} from './dom.js';

/** Methods with a resolved pipeline, and that of their first run. */
function pipelines(study) {
  return study.methods.map((name) => {
    const run = study.runs.find((r) => r.method === name && r.config !== null);
    return run && {name, values: new Map(study.configs[run.config])};
  }).filter(Boolean);
}

/** [path, a, b, differs]; a change of a stage's type is told first, its keys after it. */
function compare(a, b) {
  const paths = [...new Set([...a.keys(), ...b.keys()])].sort((x, y) => {
    const stem = (path) => path.replace(/\.type$/, '.');
    return stem(x) < stem(y) ? -1 : stem(x) > stem(y) ? 1 : 0;
  });
  return paths.map((path) => [path, a.get(path), b.get(path), a.get(path) !== b.get(path)]);
}

export function configSection(study) {
  const all = pipelines(study);
  if (!all.length) return null;
  const baseline = study.baselines.find((b) => b !== null && b !== undefined);
  const first = Math.max(all.findIndex((p) => p.name === study.methods[baseline]), 0);
  const state = {a: first, b: all.length > 1 ? (first + 1) % all.length : first, whole: false};
  const place = scroller();
  const draw = () => {
    const rows = compare(all[state.a].values, all[state.b].values);
    const differences = rows.filter((row) => row[3]).length;
    const cell = (value, differs) => h('td', {class: differs ? 'differs' : ''}, value === undefined ? h('span', {class: 'note'}, 'missing') : h('code', null, value));
    place.replaceChildren(
      h('p', {class: 'note'}, differences ? `${differences} of ${rows.length} values differ.` : 'No difference.'),
      h('table', {class: 'plain configs'},
        h('thead', null, h('tr', null, ['key', all[state.a].name, all[state.b].name].map((text) => h('th', {scope: 'col'}, text)))),
        h('tbody', null, rows.filter((row) => state.whole || row[3]).map(([path, a, b, differs]) =>
          h('tr', null, h('th', {scope: 'row'}, h('code', null, path)), cell(a, differs), cell(b, differs))))));
  };
  const pick = (side, label) => select(label, all.map((p, i) => [i, p.name]), state[side], (value) => { state[side] = Number(value); draw(); });
  draw();
  return section('configs', 'Configuration', 'Resolved pipelines, every key at its effective value; the first run of each method.',
    h('div', {class: 'tools'}, pick('a', 'first method'), h('span', null, 'against'), pick('b', 'second method'),
      h('label', null, h('input', {type: 'checkbox', onchange: (event) => { state.whole = event.target.checked; draw(); }}), ' equal values too')),
    place);
}

/** Leaves of a manifest as [path, text]. */
function leaves(value, path, out) {
  if (Array.isArray(value)) out.push([path, value.map((v) => (typeof v === 'object' ? JSON.stringify(v) : String(v))).join(' ')]);
  else if (value !== null && typeof value === 'object') for (const [key, v] of Object.entries(value)) leaves(v, path ? `${path}.${key}` : key, out);
  else out.push([path, value === null ? '' : String(value)]);
  return out;
}

function facts(pairs) {
  return scroller(h('table', {class: 'plain configs'}, h('tbody', null, pairs.map(([path, text]) =>
    h('tr', null, h('th', {scope: 'row'}, h('code', null, path)), h('td', null, text.includes('\n') ? h('pre', null, text) : h('code', null, text)))))));
}

export function manifestSection(study) {
  const runs = study.runs.filter((run) => run.manifest);
  if (!runs.length) return null;
  const flat = runs.map((run) => new Map(leaves(run.manifest, '', [])));
  const shared = [...flat[0]].filter(([path, text]) => flat.every((map) => map.get(path) === text));
  const sharedPaths = new Set(shared.map(([path]) => path));
  const place = h('div');
  const show = (index) => {
    const run = runs[index];
    const notes = [['status', `${run.status}${run.reason ? `: ${run.reason}` : ''}`],
      ['initialisation', run.summary?.initialisation ?? ''], ['calibration', run.summary?.calibration ?? ''],
      ...(run.summary?.notes ?? []).map((note) => ['note', String(note)])];
    place.replaceChildren(facts([...notes.filter(([, text]) => text), ...[...flat[index]].filter(([path]) => !sharedPaths.has(path))]));
  };
  show(0);
  return section('manifest', 'Manifest', `What ${runs.length === 1 ? 'the run' : `all ${runs.length} runs`} had in common: program, compiler, libraries, machine.`,
    facts(shared),
    h('div', {class: 'tools'}, h('h3', null, 'Of one run'), select('run', runs.map((run, i) => [i, `${run.data} / ${run.method}${run.order && run.order !== '0' ? ` / order ${run.order}` : ''}`]), 0, (i) => show(Number(i)))),
    place);
}

export function failureSection(study) {
  const bad = study.runs.filter((run) => !run.good);
  if (!bad.length) return null;
  return section('failures', 'Runs that failed or diverged', 'They count in every table as worse than any figure.',
    h('div', {class: 'scroll'}, h('table', {class: 'plain'},
      h('thead', null, h('tr', null, ['data', 'method', 'status', 'reason'].map((text) => h('th', {scope: 'col'}, text)))),
      h('tbody', null, bad.map((run) => h('tr', null, h('th', {scope: 'row'}, run.data), h('td', null, run.method),
        h('td', null, h('span', {class: 'badge bad'}, run.status)), h('td', {class: 'text'}, run.reason)))))));
}
