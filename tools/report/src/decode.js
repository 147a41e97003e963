// The numbers of the page: differences in groups of 7 bits, see framework/lab/include/aslio/report/encode.hpp.

export function bytesOf(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Values in multiples of `unit`. */
export function unpack(text, unit) {
  const bytes = bytesOf(text);
  let count = 0;
  for (let i = 0; i < bytes.length; i++) if (bytes[i] < 128) count++;
  const values = new Float64Array(count);
  let last = 0, at = 0;
  for (let k = 0; k < count; k++) {
    let zigzag = 0, place = 1;
    for (;;) {
      const byte = bytes[at++];
      zigzag += (byte & 127) * place;
      if (byte < 128) break;
      place *= 128;
    }
    last += zigzag % 2 ? -(zigzag + 1) / 2 : zigzag / 2;
    values[k] = last * unit;
  }
  return values;
}

const TIME_UNIT = 1e-4, LENGTH_UNIT = 1e-3, ERROR_UNIT = 1e-4;

/** {t, v, unit}: a channel over time; v is NaN halfway where values are missing, and in multiples of `unit`. */
export function channelOf(packed) {
  if (!packed) return packed;
  const t = unpack(packed.t, TIME_UNIT), v = unpack(packed.v, packed.unit);
  if (!packed.breaks) return {t, v, unit: packed.unit};
  const breaks = new Set(unpack(packed.breaks, 1));
  const all = {t: [], v: []};
  t.forEach((time, i) => {
    if (breaks.has(i)) {
      all.t.push((t[i - 1] + time) / 2);
      all.v.push(NaN);
    }
    all.t.push(time);
    all.v.push(v[i]);
  });
  return {t: Float64Array.from(all.t), v: Float64Array.from(all.v), unit: packed.unit};
}

/** {t, x, y, z, q, dx, dy, dz, e}: a trajectory; errors only where there is truth, e is NaN at poses that have none. */
export function pathOf(packed) {
  if (!packed) return null;
  const path = {t: unpack(packed.t, TIME_UNIT)};
  for (const name of ['x', 'y', 'z']) path[name] = unpack(packed[name], LENGTH_UNIT);
  path.q = new Int8Array(bytesOf(packed.q).buffer);
  if (packed.dx) {
    for (const name of ['dx', 'dy', 'dz']) path[name] = unpack(packed[name], ERROR_UNIT);
    const known = packed.known && bytesOf(packed.known);
    path.e = path.t.map((_, i) => (known && !known[i] ? NaN : Math.hypot(path.dx[i], path.dy[i], path.dz[i])));
  }
  return path;
}

export function cloudOf(packed) {
  return {x: unpack(packed.x, 0.01), y: unpack(packed.y, 0.01), z: unpack(packed.z, 0.01)};
}

/** Index i with t[i] <= time < t[i + 1], clamped. */
export function indexAt(t, time) {
  let low = 0, high = t.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (t[middle] <= time) low = middle;
    else high = middle - 1;
  }
  return low;
}
