// Small statistics over plain arrays.

export const sum = (values) => values.reduce((total, value) => total + value, 0);
export const mean = (values) => sum(values) / values.length;
export const rms = (values) => Math.sqrt(mean(values.map((value) => value * value)));
export const largest = (values) =>
  values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);

/** [smallest, largest] of any number of values; null is none. */
export function range(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value === null || value === undefined) continue;
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}

/** Of values that are sorted, by linear interpolation. */
export function quantile(sorted, share) {
  const at = share * (sorted.length - 1);
  const low = Math.floor(at);
  const high = Math.min(low + 1, sorted.length - 1);
  return sorted[low] + (at - low) * (sorted[high] - sorted[low]);
}

export function deviation(values) {
  const centre = mean(values);
  return Math.sqrt(
    sum(values.map((value) => (value - centre) ** 2)) / Math.max(1, values.length - 1),
  );
}

/** Of the standard normal distribution (Acklam's rational approximation, to 1e-9). */
export function normalQuantile(p) {
  const a = [
    -39.69683028665376, 220.9460984245205, -275.9285104469687, 138.357751867269, -30.66479806614716,
    2.506628277459239,
  ];
  const b = [
    -54.47609879822406, 161.5858368580409, -155.6989798598866, 66.80131188771972,
    -13.28068155288572,
  ];
  const c = [
    -0.007784894002430293, -0.3223964580411365, -2.400758277161838, -2.549732539343734,
    4.374664141464968, 2.938163982698783,
  ];
  const d = [0.007784695709041462, 0.3224671290700398, 2.445134137142996, 3.754408661907416];
  const tail = (q) =>
    (((((c[0] * q + c[1]) * q + c[2]) * q + c[3]) * q + c[4]) * q + c[5]) /
    ((((d[0] * q + d[1]) * q + d[2]) * q + d[3]) * q + 1);
  if (p < 0.02425) return tail(Math.sqrt(-2 * Math.log(p)));
  if (p > 1 - 0.02425) return -tail(Math.sqrt(-2 * Math.log(1 - p)));
  const q = p - 0.5;
  const r = q * q;
  return (
    ((((((a[0] * r + a[1]) * r + a[2]) * r + a[3]) * r + a[4]) * r + a[5]) * q) /
    (((((b[0] * r + b[1]) * r + b[2]) * r + b[3]) * r + b[4]) * r + 1)
  );
}

/** Indices by key, in the order of first use. */
export function groups(indices, key) {
  const found = new Map();
  for (const i of indices) {
    const name = key(i);
    if (!found.has(name)) found.set(name, []);
    found.get(name).push(i);
  }
  return found;
}

/** A stream of numbers in [0, 1) that is the same in every browser (mulberry32). */
export function stream(seed) {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = Math.imul(state ^ (state >>> 15), 1 | state);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** 95 % interval of the rms of values, by bootstrap over groups that are alike: [lower, upper]. */
export function rmsInterval(lists, draws = 400) {
  const squares = lists.map((list) => [sum(list.map((v) => v * v)), list.length]);
  if (squares.length < 3) return null;
  const random = stream(1);
  const found = [];
  for (let draw = 0; draw < draws; ++draw) {
    let total = 0;
    let count = 0;
    for (let i = 0; i < squares.length; ++i) {
      const [s, n] = squares[Math.floor(random() * squares.length)];
      total += s;
      count += n;
    }
    found.push(Math.sqrt(total / count));
  }
  found.sort((x, y) => x - y);
  return [quantile(found, 0.025), quantile(found, 0.975)];
}
