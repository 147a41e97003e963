// What the heat map shows: methods by sequences against the baseline, or the axes of the study.
import {ratioOf, shown} from './model.js';

/** Log2 of the ratio of what failed: beyond any scale. */
const WORST = 9;

/** The method's name without the suffixes of the axes. */
function baseName(study, run) {
  return study.axes.reduceRight((name, axis, k) => {
    const suffix = `_${axis.split('.').pop()}_${run.axes[k]}`;
    return name.endsWith(suffix) ? name.slice(0, -suffix.length) : name;
  }, run.method);
}

function geometricMean(values) {
  return values.length ? Math.exp(values.reduce((sum, v) => sum + Math.log(v), 0) / values.length) : NaN;
}

/** Columns: values of the first axis; rows: methods with the values of the others. */
function overAxes(study, table, hidden) {
  const columns = [], rows = [], cells = [];
  study.methods.forEach((method, m) => {
    const run = study.runs.find((r) => r.method === method);
    if (!run || hidden.has(m)) return;
    const column = `${study.axes[0].split('.').pop()} ${run.axes[0]}`;
    const row = [baseName(study, run), ...study.axes.slice(1).map((axis, k) => `${axis.split('.').pop()} ${run.axes[k + 1]}`)].join(', ');
    if (!columns.includes(column)) columns.push(column);
    if (!rows.includes(row)) rows.push(row);
    const medians = table.lines.map((line) => line.cells[m].median).filter((v) => v > 0);
    const failed = table.lines.filter((line) => ['failed', 'diverged'].includes(line.cells[m].mark)).length;
    const value = geometricMean(medians);
    if (!failed && !Number.isFinite(value)) return;  // nothing run yet
    // A mean over what did not fail would make failing pay.
    const rest = Number.isFinite(value) ? `${shown(table, value)} ${table.unit}` : 'no figure';
    cells.push({value: [columns.indexOf(column), rows.indexOf(row), failed ? NaN : value], m, failed: failed > 0,
      text: failed ? `${failed}x` : shown(table, value),
      note: `${method}\n${failed ? `${failed} of ${table.lines.length} sequences failed; the others: ${rest}` : rest}`});
  });
  // Colours as of ratios, on a scale of powers around 1: a linear one hides 0.89 against 1.10 where something is ten times as large.
  const named = cells.find((cell) => study.baselines.includes(cell.m) && !cell.failed)?.value[2];
  const middle = named ?? geometricMean(cells.map((cell) => cell.value[2]).filter((v) => v > 0));
  for (const cell of cells) cell.value[2] = cell.failed ? WORST : Math.log2(cell.value[2] / middle);
  return {columns, rows, cells,
    words: `Geometric mean over the sequences of the medians; colours by the ratio to ${named ? 'the baseline' : 'the mean of all cells'}. 2x: two sequences failed, which is worse than any figure.`};
}

/** The reference of a line: the baseline of the method, or the best of the line where the study names none. */
function reference(study, line, m) {
  const baseline = study.baselines[m] ?? study.baselines.find((b) => b !== null && b !== undefined);
  if (baseline !== undefined && baseline !== null) return line.cells[baseline].median;
  return Math.min(...line.cells.map((cell) => cell.median ?? Infinity));
}

function overSequences(study, table, hidden) {
  const methods = study.methods.map((_, m) => m).filter((m) => !hidden.has(m));
  const cells = [];
  table.lines.forEach((line, row) => methods.forEach((m, column) => {
    const cell = line.cells[m], against = reference(study, line, m);
    const ratio = cell.mark === 'value' && against > 0 ? cell.median / against : NaN;
    const mark = {failed: 'x', diverged: '-'}[cell.mark];
    if (!Number.isFinite(ratio) && !mark) return;
    cells.push({value: [column, row, mark ? WORST : Math.log2(Math.max(ratio, 1e-6))], text: mark ?? ratioOf(ratio),
      note: `${study.labels[m]}, ${line.sequence}\n${mark ? 'failed' : `${shown(table, cell.median)} ${table.unit}, ${ratioOf(ratio)} of the reference`}`});
  }));
  const named = study.baselines.some((b) => b !== null);
  return {columns: methods.map((m) => study.labels[m]), rows: table.lines.map((line) => line.sequence), cells,
    words: `Medians over those of the ${named ? 'baseline' : 'best of the line'}: below 1 is better.`};
}

export function heatData(study, table, hidden) {
  return study.axes.length ? overAxes(study, table, hidden) : overSequences(study, table, hidden);
}
