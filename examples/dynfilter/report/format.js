// Numbers as text.

const NONE = "–";

function figure(value, digits, unit) {
  if (value === null || value === undefined || !Number.isFinite(value)) return NONE;
  return value.toFixed(digits) + (unit ? " " + unit : "");
}

function counted(n, one, many) {
  return `${n} ${n === 1 ? one : many || one + "s"}`;
}

/** About `count` round values from `low` to `high`. */
function roundTicks(low, high, count) {
  const span = high - low;
  if (!(span > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(span / count));
  const step = [1, 2, 5, 10].map((n) => n * power).find((s) => span / s <= count) || 10 * power;
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9; ++k) ticks.push(k * step);
  return ticks;
}

/** As many decimals as tell the ticks exactly. */
function tickText(value, ticks) {
  const step = ticks.length > 1 ? Math.abs(ticks[1] - ticks[0]) : Math.abs(value) || 1;
  let digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const exact = (t) => Math.abs(t - Number(t.toFixed(digits))) < 1e-6 * step;
  if (!exact(step)) ++digits; // 0.25
  return value.toFixed(digits).replace(/^-(0\.?0*)$/, "$1");
}

/** Powers of ten; between them 2 and 5 where there is room. */
function logTicks(low, high) {
  const few = high / low < 300;
  const ticks = [];
  for (let power = Math.floor(Math.log10(low) + 1e-9); 10 ** power <= high; ++power)
    for (const digit of few ? [1, 2, 5] : [1]) {
      const tick = Number(`${digit}e${power}`);
      if (tick >= low * (1 - 1e-9) && tick <= high) ticks.push(tick);
    }
  return ticks;
}

function logText(tick) {
  return tick >= 1e-4 ? String(tick) : tick.toExponential(0);
}

function known(values) {
  return values.filter((v) => v !== null && v !== undefined);
}

function largest(values) {
  return values.reduce((most, v) => (v !== null && v !== undefined && v > most ? v : most), -Infinity);
}

function median(values) {
  const sorted = known(values).sort((a, b) => a - b);
  const half = sorted.length >> 1;
  if (sorted.length === 0) return null;
  return sorted.length % 2 ? sorted[half] : (sorted[half - 1] + sorted[half]) / 2;
}

/** At a share of the way from the least value to the largest, linear between two of them. */
function quantile(values, share) {
  const sorted = known(values).sort((a, b) => a - b);
  if (sorted.length === 0) return null;
  const at = share * (sorted.length - 1), below = Math.floor(at);
  return sorted[below] + (at - below) * (sorted[Math.min(below + 1, sorted.length - 1)] - sorted[below]);
}

/** As evo has them: the deviation divides by n. */
function errorStatistics(values) {
  const errors = known(values), n = errors.length;
  if (n === 0) return null;
  const sum = (of) => errors.reduce((total, e) => total + of(e), 0);
  const mean = sum((e) => e) / n;
  return { n, rmse: Math.sqrt(sum((e) => e * e) / n), mean, median: median(errors), std: Math.sqrt(sum((e) => (e - mean) ** 2) / n),
    min: Math.min(...errors), max: largest(errors) };
}
