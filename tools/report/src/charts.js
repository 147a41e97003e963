// Boxes over seeds, ratios to the baseline, cost against accuracy.
import {BoxplotChart, HeatmapChart, LineChart, ScatterChart} from 'echarts/charts';
import {GridComponent, MarkLineComponent, TooltipComponent, VisualMapComponent} from 'echarts/components';
import * as echarts from 'echarts/core';
import {LabelLayout} from 'echarts/features';
import {SVGRenderer} from 'echarts/renderers';
import {h, section, segmented, whenNear} from './dom.js';
import {brief, heading, ratioOf} from './model.js';
import {heatData} from './heat.js';
import {colourOf, dark, ink} from './theme.js';

echarts.use([BoxplotChart, HeatmapChart, LineChart, ScatterChart, GridComponent, MarkLineComponent, TooltipComponent, VisualMapComponent, LabelLayout, SVGRenderer]);

/** A chart in the place, drawn again when what it shows or its width changes. */
class Chart {
  constructor(label, options, height) {
    this.place = h('div', {class: 'chart', role: 'img', 'aria-label': label});
    this.options = options;
    this.height = height;
    whenNear(this.place, () => {
      this.near = true;
      this.draw();
      new ResizeObserver(() => this.draw()).observe(this.place);
    });
  }

  draw() {
    const width = this.place.clientWidth;
    if (!width || !this.near) return;
    const height = this.height();
    this.chart ??= echarts.init(this.place, null, {renderer: 'svg', width, height});
    this.chart.resize({width, height});
    this.chart.setOption({...base(), ...this.options(width, this.chart)}, {notMerge: true});
  }
}

function base() {
  return {
    animation: false, backgroundColor: 'transparent',
    textStyle: {fontFamily: 'system-ui, sans-serif', color: ink('text')},
    tooltip: {renderMode: 'richText', confine: true, backgroundColor: ink('card'), borderColor: ink('line'), textStyle: {color: ink('text'), fontSize: 12}},
  };
}

function axis(extra) {
  const line = {lineStyle: {color: ink('line')}};
  return {
    axisLine: line, axisTick: line, splitLine: line, minorSplitLine: {show: false},
    axisLabel: {color: ink('muted'), fontSize: 11, hideOverlap: true}, nameTextStyle: {color: ink('muted'), fontSize: 11}, ...extra,
  };
}

/** Linear where the values span little, as powers of ten would leave most of the chart empty; from 0 where there is but one. */
function fitAxis(name, values, extra) {
  const low = values.length ? Math.min(...values) : 0, high = values.length ? Math.max(...values) : 1;
  return high / low > 30 ? logAxis(name, extra) : axis({type: 'value', name, scale: high > 1.001 * low, ...extra});
}

const logAxis = (name, extra) => axis({type: 'log', name, axisLabel: {color: ink('muted'), fontSize: 11, formatter: brief, hideOverlap: true}, ...extra});

function quantile(sorted, q) {
  const at = q * (sorted.length - 1), i = Math.floor(at);
  return i + 1 < sorted.length ? sorted[i] + (at - i) * (sorted[i + 1] - sorted[i]) : sorted[i];
}

/** One box per sequence and method, of the runs that held; what failed is counted below the sequence and in the tooltip. */
function boxOptions(study, choice) {
  const table = study.table(choice.get('metric'));
  const methods = study.methods.map((_, m) => m).filter((m) => !choice.get('hidden').has(m));
  const logarithmic = choice.get('logBoxes') && table.smaller;
  const series = [];
  const held = (run) => run.good && !(table.metric === 'end_to_end_m' && Number.isFinite(study.figure(run, 'failed_at')));
  const lost = study.sequences.map(() => 0);
  methods.forEach((m) => {
    const boxes = [], failed = [];
    study.sequences.forEach((sequence, i) => {
      const runs = study.runsOf(sequence, study.methods[m]);
      failed.push([runs.filter((run) => !held(run)).length, runs.length]);
      lost[i] += failed[i][0];
      const values = runs.filter(held)
        .map((run) => table.scale * study.figure(run, table.metric)).filter((v) => Number.isFinite(v) && (!logarithmic || v > 0)).sort((a, b) => a - b);
      boxes.push(values.length ? [0, 0.25, 0.5, 0.75, 1].map((q) => quantile(values, q)) : [NaN, NaN, NaN, NaN, NaN]);
    });
    const colour = colourOf(m);
    series.push({
      type: 'boxplot', name: study.labels[m], data: boxes, boxWidth: [3, 26],
      itemStyle: {color: `${colour}33`, borderColor: colour, borderWidth: 1.4},
      tooltip: {formatter: ({name, seriesName, data, dataIndex}) => `${seriesName}, ${name}\n${failed[dataIndex][0] ? `${failed[dataIndex][0]} of ${failed[dataIndex][1]} runs failed; the others:\n` : ''}median ${brief(data[3])}\nquartiles ${brief(data[2])} to ${brief(data[4])}\nall ${brief(data[1])} to ${brief(data[5])}`},
    });
  });
  return {
    grid: {left: 56, right: 12, top: 26, bottom: study.sequences.length > 12 ? 80 : 44},
    xAxis: axis({type: 'category', data: study.sequences, axisLabel: {color: ink('muted'), fontSize: 11, lineHeight: 14, interval: 0, rotate: study.sequences.length > 12 ? 45 : 0,
      formatter: (name, i) => (lost[i] ? `${name}\n${lost[i]} failed` : name)}}),
    yAxis: logarithmic ? logAxis(heading(table), {}) : axis({type: 'value', name: heading(table)}),
    series,
  };
}

/** Places the names of points where they cover neither each other nor a point: beside their own, or as near to it as there is room. */
function apart(chart, values) {
  const taken = [];
  const overlaps = (a, b) => a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
  return ({labelRect, rect, dataIndex}) => {
    if (dataIndex === 0) {
      taken.length = 0;
      for (const value of values) {
        const [x, y] = chart.convertToPixel({xAxisIndex: 0, yAxisIndex: 0}, value);
        taken.push({x: x - 7, y: y - 7, width: 14, height: 14});
      }
    }
    const {width, height} = labelRect, x = rect.x + rect.width / 2, y = rect.y + rect.height / 2;
    const inside = (box) => box.x >= 0 && box.y >= 0 && box.x + width <= chart.getWidth() && box.y + height <= chart.getHeight() - 30;
    let place = null;
    for (let away = 10; away < 160 && !place; away += 8) {
      // Above right first: the front leaves a point to the right and below.
      place = [[x + away - 4, y - away + 4 - height], [x - away - width, y + away], [x - width / 2, y - away - height], [x - away - width, y - height / 2],
        [x + away, y - height / 2], [x - width / 2, y + away], [x + away, y + away], [x - away - width, y - away - height]]
        .map(([left, top]) => ({x: left, y: top, width, height})).find((box) => inside(box) && !taken.some((other) => overlaps(box, other)));
    }
    place ??= labelRect;
    taken.push({x: place.x - 2, y: place.y, width: width + 4, height});
    return {x: place.x, y: place.y, align: 'left', verticalAlign: 'top'};
  };
}

/** Typical cost and error of every method; the line joins those that none beats in both. */
function frontOptions(study, choice, chart) {
  const table = study.table(choice.get('metric')), cost = study.table('cpu_s_per_s');
  // Of sequences that have both figures: two means over different ones are no point.
  const both = (m, i) => [table, cost].every((t) => t.lines[i]?.cells[m].mark === 'value' && t.lines[i].cells[m].median > 0);
  const mean = (t, m) => {
    const values = t.lines.filter((_, i) => both(m, i)).map((line) => line.cells[m].median);
    return values.length ? Math.exp(values.reduce((sum, v) => sum + Math.log(v), 0) / values.length) : null;
  };
  const points = study.labels.map((name, m) => ({name, m, failed: table.lines.filter((line) => line.cells[m].mark !== 'value').length,
    value: [mean(cost, m), table.scale * mean(table, m)]})).filter((p) => !choice.get('hidden').has(p.m) && p.value[0] && p.value[1]);
  const clouds = points.map(({m}) => ({type: 'scatter', symbolSize: 4, silent: true, itemStyle: {color: colourOf(m), opacity: 0.3},
    data: study.runs.filter((run) => run.method === study.methods[m] && run.good)
      .map((run) => [study.figure(run, 'cpu_s_per_s'), table.scale * study.figure(run, table.metric)]).filter(([x, y]) => x > 0 && y > 0)}));
  const all = [...points.map((p) => p.value), ...clouds.flatMap((cloud) => cloud.data)];
  const front = [...points].filter((p) => !p.failed).sort((a, b) => a.value[0] - b.value[0] || a.value[1] - b.value[1])
    .filter((p, i, all) => all.slice(0, i).every((q) => q.value[1] > p.value[1])).map((p) => p.value);
  return {
    grid: {left: 60, right: 24, top: 30, bottom: 42},
    xAxis: fitAxis('CPU [s per s of data]', all.map((v) => v[0]), {nameLocation: 'middle', nameGap: 26}),
    yAxis: fitAxis(heading(table), all.map((v) => v[1]), {}),
    series: [...clouds, {type: 'line', data: front, symbol: 'none', silent: true, step: 'end', lineStyle: {color: ink('muted'), type: 'dashed', width: 1}},
      {type: 'scatter', data: points.map((p) => ({value: p.value, name: p.name, failed: p.failed, symbolSize: 13, symbol: p.failed ? 'emptyCircle' : 'circle',
        itemStyle: {color: colourOf(p.m), borderColor: ink('card'), borderWidth: 1},
        label: {show: true, formatter: () => p.name, position: 'right', color: ink('text'), fontSize: 11}})),
      labelLayout: apart(chart, points.map((p) => p.value)),
      tooltip: {formatter: ({name, value, data}) => `${name}\nCPU ${brief(value[0])} s per s\n${table.title} ${brief(value[1])} ${table.unit}`
        + (data.failed ? `, without the ${data.failed} of ${table.lines.length} sequences that failed or are missing` : '')}}],
  };
}

function heatOptions(study, choice) {
  const table = study.table(choice.get('metric'));
  const {columns, rows, cells} = heatData(study, table, choice.get('hidden'));
  const values = cells.map((cell) => cell.value[2]).filter(Number.isFinite);
  // Full colour at a factor of 1.5 at least, so that 1.06 stays pale, and of 2 at most, so that 0.89 is told from 1.10 beside a 10.
  const reach = Math.min(Math.max(...values.map(Math.abs), Math.log2(1.5)), 1);
  const colours = dark() ? ['#2f9e74', '#23262d', '#d0653d'] : ['#1b8a5f', '#f7f5f0', '#cf5a2b'];
  const label = ({data}) => data.text;
  return {
    grid: {left: 8, right: 8, top: 8, bottom: 60, containLabel: true},
    xAxis: axis({type: 'category', data: columns, splitArea: {show: false}, axisLabel: {color: ink('muted'), fontSize: 11, interval: 0, rotate: columns.join('').length > 60 ? 30 : 0}}),
    yAxis: axis({type: 'category', data: rows, inverse: true, axisLabel: {color: ink('muted'), fontSize: 11}}),
    visualMap: {min: -reach, max: reach, calculable: false, orient: 'horizontal', left: 'center', bottom: 0,
      itemHeight: 120, itemWidth: 10, inRange: {color: colours}, textStyle: {color: ink('muted'), fontSize: 11},
      text: [`${ratioOf(2 ** reach)} or more`, `${ratioOf(2 ** -reach)} or less`]},
    series: [{type: 'heatmap', data: cells.map((cell) => ({...cell, label: {color: labelInk(cell.value[2], reach)}})),
      label: {show: true, formatter: label, fontSize: 11}, itemStyle: {borderColor: ink('card'), borderWidth: 2},
      tooltip: {formatter: ({data}) => data.note}}],
  };
}

function labelInk(value, reach) {
  return Math.abs(value) > 0.55 * reach && !dark() ? '#fff' : ink('text');
}

export function chartsSection(study, choice) {
  const table = () => study.table(choice.get('metric'));
  const boxes = new Chart('Error distribution', () => boxOptions(study, choice), () => 320);
  const heat = new Chart('Ablation heat map', () => heatOptions(study, choice),
    () => Math.max(240, 26 * heatData(study, table(), choice.get('hidden')).rows.length + 130));
  const front = study.figures.includes('cpu_s_per_s') && new Chart('Cost against accuracy', (width, chart) => frontOptions(study, choice, chart), () => 340);
  const charts = [boxes, heat, front].filter(Boolean);
  const titles = h('strong');
  const draw = () => {
    titles.textContent = heading(table());
    heatCard.hidden = !table().smaller;
    if (frontCard) frontCard.hidden = !table().smaller || table().metric === 'cpu_s_per_s';
    for (const chart of charts) chart.draw();
  };
  const heatCard = h('div', {class: 'card'}, h('h3', null, study.axes.length ? 'Over the axes of the study' : 'Ratio to the baseline'),
    h('p', {class: 'note'}, heatData(study, table(), new Set()).words), heat.place);
  const frontCard = front && h('div', {class: 'card'}, h('h3', null, 'Cost against accuracy'),
    h('p', {class: 'note'}, 'Geometric means over sequences; dots are runs. Hollow: some sequences failed or are missing. The position is that of the others, and it cannot be on the front (dashed).'), front.place);
  choice.on(['metric', 'hidden', 'theme', 'logBoxes'], draw);
  queueMicrotask(draw);
  return section('charts', 'Distribution, ablation, cost', ['Of the figure chosen in the results: ', titles],
    h('div', {class: 'card'}, h('div', {class: 'tools'}, h('h3', null, 'Over the seeds'), h('span', {class: 'push'}),
      segmented('scale', [[false, 'linear'], [true, 'logarithmic']], choice.get('logBoxes'), (logBoxes) => choice.set({logBoxes}))), boxes.place),
    h('div', {class: 'pair'}, heatCard, frontCard));
}
