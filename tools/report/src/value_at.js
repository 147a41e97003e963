// What a line of a chart shows between its samples.

/** Where the line as drawn is at time t: between two samples, or on the step that ends with the next one. NaN: there is none. */
export function valueAt({t, v}, time, stepped, logarithmic) {
  if (!(time >= t[0] && time <= t[t.length - 1])) return NaN;
  let low = 0, high = t.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (t[middle] <= time) low = middle;
    else high = middle;
  }
  if (time === t[low]) return v[low];
  if (time === t[high] || stepped) return Number.isFinite(v[low]) ? v[high] : NaN;
  const part = (time - t[low]) / (t[high] - t[low]);
  if (logarithmic && v[low] > 0 && v[high] > 0) return Math.exp((1 - part) * Math.log(v[low]) + part * Math.log(v[high]));
  return (1 - part) * v[low] + part * v[high];
}
