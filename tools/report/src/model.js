// The study as the page holds it, and what is chosen to be seen.
import {channelOf, cloudOf, pathOf} from './decode.js';

/** An object put together from what it shares with others and the rest of it. */
function joined(common, rest) {
  const inside = (value) => value !== null && typeof value === 'object' && !Array.isArray(value);
  const out = {...common};
  for (const [key, value] of Object.entries(rest)) {
    out[key] = Object.hasOwn(out, key) && inside(out[key]) && inside(value) ? joined(out[key], value) : value;
  }
  return out;
}

export class Study {
  constructor(json) {
    Object.assign(this, json);
    for (const run of this.runs) if (run.manifest) run.manifest = joined(this.manifest, run.manifest);
    this.runs.forEach((run, index) => {
      run.index = index;
      run.good = run.status === 'ok' || run.status === 'degraded';
    });
    this.labels ??= this.methods;
    this.decoded = new Map();
  }

  table(metric) {
    return this.tables.find((table) => table.metric === metric) ?? this.tables[0];
  }

  /** What people call the method of a run. */
  labelOf(run) {
    return this.labels[this.methods.indexOf(run.method)] ?? run.method;
  }

  runsOf(sequence, method) {
    return this.runs.filter((run) => run.sequence === sequence && run.method === method);
  }

  /** Groups of runs over the same recording with the same order seed, in the order of the study. */
  get recordings() {
    if (!this.groups) {
      const groups = new Map();
      for (const run of this.runs) {
        const key = run.order === '0' || run.order === '' ? run.data : `${run.data}, order ${run.order}`;
        if (!groups.has(key)) groups.set(key, {key, data: run.data, sequence: run.sequence, runs: []});
        groups.get(key).runs.push(run);
      }
      this.groups = [...groups.values()];
    }
    return this.groups;
  }

  figure(run, name) {
    const index = this.figures.indexOf(name);
    return index < 0 ? null : run.figures[index];
  }

  /** The course of a run, decoded when first looked at. */
  course(run) {
    if (!run.series) return null;
    if (!this.decoded.has(run)) {
      const channels = {};
      for (const [name, packed] of Object.entries(run.series.channels)) channels[name] = channelOf(packed);
      this.decoded.set(run, {
        channels, path: pathOf(run.series.path), weak: run.series.weak ?? [], stages: run.series.stages_ms ?? null,
        aligned: run.series.aligned,
      });
    }
    return this.decoded.get(run);
  }

  recording(name) {
    const packed = Object.hasOwn(this.courses, name) ? this.courses[name] : null;
    if (!packed) return {};
    const key = `recording ${name}`;
    if (!this.decoded.has(key)) {
      this.decoded.set(key, {
        truth: pathOf(packed.truth), overlap: channelOf(packed.overlap),
        map: packed.map && {...cloudOf(packed.map), method: packed.map.method, voxel: packed.map.voxel},
      });
    }
    return this.decoded.get(key);
  }

}

/** What is chosen; sections listen. */
export class Choice {
  constructor(values) {
    this.values = values;
    this.listeners = [];
  }

  get(name) {
    return this.values[name];
  }

  set(changes) {
    const changed = Object.keys(changes).filter((name) => this.values[name] !== changes[name]);
    if (!changed.length) return;
    Object.assign(this.values, changes);
    for (const {names, listener} of this.listeners) if (names.some((name) => changed.includes(name))) listener();
  }

  on(names, listener) {
    this.listeners.push({names, listener});
  }
}

/** A number with three digits that count. */
export function brief(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '';
  const size = Math.abs(value);
  if (size === 0) return '0';
  if (size >= 1e6) return value.toExponential(1).replace('.0', '').replace('+', '');
  if (size >= 1000) return value.toFixed(0);
  return value.toPrecision(3).replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '');
}

/** A ratio, so that 1.00 is told from 1.02. */
export function ratioOf(value) {
  return value >= 100 ? value.toFixed(0) : value >= 10 ? value.toFixed(1) : value.toFixed(2);
}

/** Whether a comparison shows more than chance, by the p-value that is corrected for the lines of its table. */
export function significant(comparison) {
  const text = (comparison?.more ?? []).find(([name]) => name === 'p (Holm)')?.[1] ?? '';
  return text.startsWith('<') || (text !== '' && Number(text) < 0.05);
}

/** How strong a colour a ratio gets, 0 to 1: by its size, a factor of two in full. */
export function strengthOf(ratio) {
  return ratio > 0 ? Math.min(Math.abs(Math.log2(ratio)), 1) : 1;
}

export function shown(table, value) {
  return value === null || value === undefined ? '' : (table.scale * value).toFixed(table.decimals);
}

export function heading(table) {
  return table.unit ? `${table.title} [${table.unit}]` : table.title;
}
