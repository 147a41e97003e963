// The runs over one recording, in space and over time, scrubbed together.
import {h, scroller, section, select, whenNear} from './dom.js';
import {brief, heading, shown} from './model.js';
import {SpaceView} from './scene.js';
import {CHANNELS, Timeline} from './timeline.js';
import {colourOf, ink, rampText} from './theme.js';

const SPEEDS = [1, 5, 20, 60];

class Explorer {
  constructor(study, choice) {
    this.study = study;
    this.choice = choice;
    this.space = new SpaceView('Trajectories in space: arrow keys turn, plus and minus zoom, Home fits');
    this.timeline = new Timeline(choice);
    this.slider = h('input', {type: 'range', min: 0, max: 1, step: 0.01, value: 0, class: 'scrub', 'aria-label': 'time',
      oninput: (event) => choice.set({time: Number(event.target.value)})});
    this.clock = h('output', {class: 'clock'});
    this.legend = h('div', {class: 'legend'});
    this.list = scroller();
    this.playButton = h('button', {type: 'button', class: 'play', 'aria-label': 'play', onclick: () => this.play()}, '\u25b6');
    choice.on(['recording'], () => this.started && this.draw(false));
    choice.on(['hidden', 'theme', 'focus'], () => this.started && this.draw(true));
    choice.on(['time'], () => this.started && this.seek());
  }

  start() {
    this.started = true;
    this.space.start();
    this.draw(false);
  }

  get group() {
    return this.study.recordings.find((group) => group.key === this.choice.get('recording')) ?? this.study.recordings[0];
  }

  /** Runs with a course whose method is shown. */
  runs() {
    const hidden = this.choice.get('hidden');
    return this.group.runs.filter((run) => run.series && !hidden.has(this.study.methods.indexOf(run.method)));
  }

  colour(run) {
    return colourOf(this.study.methods.indexOf(run.method));
  }

  draw(keepView) {
    const {truth, overlap, map} = this.study.recording(this.group.data);
    const runs = this.runs();
    const courses = runs.map((run) => ({run, course: this.study.course(run)}));
    const ends = [truth?.t, ...courses.map(({course}) => course.path?.t ?? Object.values(course.channels)[0]?.t)].filter((t) => t?.length);
    this.begin = Math.min(...ends.map((t) => t[0]), Infinity);
    this.end = Math.max(...ends.map((t) => t[t.length - 1]), -Infinity);
    if (!Number.isFinite(this.begin)) [this.begin, this.end] = [0, 1];
    this.slider.min = this.begin;
    this.slider.max = this.end;
    this.space.resize();
    this.space.show({
      runs: courses.filter(({course}) => course.path).map(({run, course}) => ({path: course.path, colour: this.colour(run), name: this.study.labelOf(run)})),
      truth, map,
    }, keepView);
    if (!keepView) {
      this.timeline.range = [this.begin, this.end];
      this.choice.set({time: this.end});
    }
    this.timeline.show(this.lines(courses, overlap), courses.map(({run, course}) => ({name: this.study.labelOf(run), colour: this.colour(run), stretches: course.weak})),
      [this.begin, this.end]);
    this.mapBox.hidden = !map;
    this.drawLegend(truth);
    this.drawList();
    this.seek();
    if (this.picker.value !== this.group.key) this.picker.value = this.group.key;
  }

  lines(courses, overlap) {
    const lines = {};
    const focus = this.choice.get('focus');
    const order = [...courses].sort((a, b) => (a.run.method === focus ? 1 : 0) - (b.run.method === focus ? 1 : 0));
    for (const [name] of CHANNELS) {
      lines[name] = order.filter(({course}) => course.channels[name])
        .map(({run, course}) => ({name: this.study.labelOf(run), colour: this.colour(run), channel: course.channels[name]}));
    }
    if (overlap && lines.sod.length) lines.sod.unshift({name: 'truth', colour: ink('truth'), channel: overlap, dash: [4, 3]});
    return lines;
  }

  drawLegend(truth) {
    const scale = this.space.scale;
    this.legend.replaceChildren(
      truth ? h('span', null, h('span', {class: 'swatch line', style: {'--c': ink('truth')}}), 'truth') : h('span', {class: 'note'}, 'no truth'),
      scale ? h('span', {class: 'ramp'}, brief(scale[0]),
        h('span', {class: 'bar', style: {background: `linear-gradient(90deg, ${[0, 0.25, 0.5, 0.75, 1].map(rampText).join(', ')})`}}),
        `${brief(scale[1])} ${scale[2]}`) : '');
  }

  /** The runs of the recording with their figures and where their time went. */
  drawList() {
    const {study} = this;
    const tables = [...new Set([...study.metrics, 'rate_hz', 'cpu_s_per_s'])].filter((name) => study.figures.includes(name)).map((name) => study.table(name));
    this.list.replaceChildren(h('table', {class: 'plain'},
      h('thead', null, h('tr', null, ['method', 'status', ...tables.map(heading), 'mean CPU of an update by stage'].map((text, i) => h('th', {scope: 'col', class: i < 2 ? 'left' : ''}, text)))),
      h('tbody', null, this.group.runs.map((run) => h('tr', {class: run.method === this.choice.get('focus') ? 'focus' : ''},
        h('th', {scope: 'row'}, h('span', {class: 'swatch', style: {'--c': this.colour(run)}}), this.study.labelOf(run)),
        h('td', {class: 'left'}, h('span', {class: `badge ${run.good ? (run.status === 'ok' ? 'good' : 'open') : 'bad'}`, title: run.reason}, run.status),
          run.reason && h('span', {class: 'reason'}, run.reason)),
        tables.map((table) => h('td', null, shown(table, study.figure(run, table.metric)))),
        h('td', null, this.stages(run)))))));
  }

  stages(run) {
    const stages = Object.entries(this.study.course(run)?.stages ?? {});
    const total = stages.reduce((sum, [, ms]) => sum + ms, 0);
    if (!total) return '';
    return h('div', {class: 'stages'}, h('div', {class: 'stack', role: 'img', 'aria-label': stages.map(([name, ms]) => `${name} ${brief(ms)} ms`).join(', ')},
      stages.map(([name, ms], i) => h('span', {title: `${name} ${brief(ms)} ms`, style: {width: `${(100 * ms) / total}%`, background: rampText(0.08 + (0.62 * i) / stages.length)}},
        ms / total > 0.16 ? name : ''))), h('span', null, `${brief(total)} ms`));
  }

  seek() {
    const time = Math.min(Math.max(this.choice.get('time'), this.begin), this.end);
    this.slider.value = time;
    this.clock.value = `${time.toFixed(1)} of ${this.end.toFixed(1)} s`;
    this.space.seek(time);
    this.timeline.seek();
  }

  play() {
    this.playing = !this.playing;
    this.playButton.textContent = this.playing ? '\u23f8' : '\u25b6';
    this.playButton.setAttribute('aria-label', this.playing ? 'pause' : 'play');
    if (!this.playing) return;
    if (this.choice.get('time') >= this.end - 1e-3) this.choice.set({time: this.begin});
    let last = performance.now();
    const step = (now) => {
      if (!this.playing) return;
      const time = this.choice.get('time') + ((now - last) / 1000) * this.speed;
      last = now;
      this.choice.set({time: Math.min(time, this.end)});
      if (time >= this.end) this.play();
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  move(by) {
    const groups = this.study.recordings, at = groups.indexOf(this.group);
    this.choice.set({recording: groups[(at + by + groups.length) % groups.length].key});
  }

  tools() {
    const {study, space} = this;
    const bySequence = study.sequences.map((sequence) => ({
      label: sequence,
      options: study.recordings.filter((group) => group.sequence === sequence).map((group) => [group.key, group.key]),
    }));
    this.picker = select('recording', bySequence, this.choice.get('recording'), (recording) => this.choice.set({recording}));
    this.mapBox = select('map', [['cut', 'map, cut open'], ['whole', 'whole map'], ['none', 'no map']], 'cut', (map) => space.set({map}));
    const redraw = () => this.drawLegend(study.recording(this.group.data).truth);
    this.speed = 5;
    return {
      top: h('div', {class: 'tools'},
        h('button', {type: 'button', 'aria-label': 'recording before', onclick: () => this.move(-1)}, '\u2039'), this.picker,
        h('button', {type: 'button', 'aria-label': 'next recording', onclick: () => this.move(1)}, '\u203a')),
      space: h('div', {class: 'tools small'},
        select('colour', [['method', 'colour: method'], ['error', 'colour: error'], ['height', 'colour: height']], 'method',
          (colour) => { space.set({colour}); redraw(); }),
        select('error drawn', [1, 10, 50, 200].map((times) => [times, `error \u00d7 ${times}`]), 1, (times) => space.set({times: Number(times)})),
        this.mapBox, h('span', {class: 'push'}),
        [['slanted', 'fit'], ['above', 'top'], ['side', 'side']].map(([kind, text]) => h('button', {type: 'button', onclick: () => space.view(kind)}, text))),
      time: h('div', {class: 'tools small'}, this.playButton,
        select('speed', SPEEDS.map((speed) => [speed, `${speed}\u00d7`]), this.speed, (speed) => { this.speed = Number(speed); }),
        this.slider, this.clock),
    };
  }
}

export function explorerSection(study, choice, chips) {
  const explorer = new Explorer(study, choice);
  const tools = explorer.tools();
  const missing = study.runs.length - study.shown;
  const place = section('runs', 'Runs',
    'All runs over one recording, aligned to the truth as for the ATE. Drag a chart to zoom, double click to see all; a click, '
    + 'or the slider, moves the time.'
    + (missing > 0 ? ` ${study.shown} of ${study.runs.length} runs have time series in this file. aslio report --limit allows more; runs that ended early have none.` : ''),
    tools.top, chips,
    h('div', {class: 'explorer'},
      h('div', {class: 'pane'}, tools.space, explorer.space.element, explorer.legend, tools.time),
      explorer.timeline.element),
    explorer.list);
  whenNear(place, () => explorer.start());
  return place;
}
