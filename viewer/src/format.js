// Formatting of numbers.

/** Four significant digits, in scientific notation for very large and small numbers. */
export function number(x, digits = 4) {
  if (!Number.isFinite(x)) return '–';
  if (x === 0) return '0';
  const a = Math.abs(x);
  if (a >= 1e5 || a < 1e-3) {
    const [m, e] = x.toExponential(digits - 1).split('e');
    return `${m}e${Number(e)}`;
  }
  return x.toFixed(Math.max(0, digits - 1 - Math.floor(Math.log10(a))));
}

/** Metres with millimetres, or with decimetres from a kilometre on. */
export const metres = (x) => x.toFixed(Math.abs(x) < 1000 ? 3 : 1);

/** An integer with thin spaces between groups of three digits. */
export const count = (n) => String(n).replace(/\B(?=(\d{3})+$)/g, '\u202f');

/** Per cent with two significant digits. */
export const percent = (x) => `${x === 0 ? '0' : x < 1e-5 ? '<\u20090.001' : (100 * x).toPrecision(2).replace(/\.0+$/, '')}\u2009%`;

/** The largest of relative errors; an unknown one is null in JSON. */
export const relativeError = (list) => (list.some((e) => !Number.isFinite(e)) ? 'unknown' : percent(Math.max(...list)));

/** A size in bytes. */
export const bytes = (n) => (n < 1e6 ? `${Math.ceil(n / 1e3)}\u2009kB` : `${(n / 1e6).toFixed(1)}\u2009MB`);

/** The factor of a light: off, or a multiplier. */
export const multiplier = (f) => (f === 0 ? 'off' : `×\u2009${f >= 100 ? f.toFixed(0) : f.toPrecision(f >= 1 ? 3 : 2).replace(/\.?0+$/, '')}`);

/** An exposure value with its sign. */
export const stops = (s) => `${s > 0 ? '+' : s < 0 ? '−' : ''}${Math.abs(s).toFixed(1)}\u2009EV`;

/** Lowest slider position, in stops: the factor zero. */
export const MIN_STOPS = -8;
/** Slider position, in stops, of a factor, and the factor of a position. */
export const toSlider = (f) => (f <= 2 ** (MIN_STOPS + 0.05) ? MIN_STOPS : Math.min(Math.log2(f), -MIN_STOPS));
export const fromSlider = (p) => (p <= MIN_STOPS + 1e-9 ? 0 : 2 ** p);

/** Round values between the ends of a scale, for tick labels. */
export function ticks(low, high, log) {
  if (!(high > low)) return [low];
  const out = [];
  if (log && low > 0) {
    const decades = Math.log10(high / low);
    const steps = decades > 4 ? [1] : decades > 1.5 ? [1, 3] : [1, 2, 5];
    for (let e = Math.floor(Math.log10(low)); e <= Math.ceil(Math.log10(high)); e++) {
      out.push(...steps.map((s) => s * 10 ** e).filter((x) => x >= low * 0.999 && x <= high * 1.001));
    }
    return out;
  }
  const rough = (high - low) / 5;
  const ten = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((s) => s * ten).find((s) => s >= rough);
  for (let k = Math.ceil(low / step - 1e-6) || 0; k * step <= high * (1 + 1e-9) + 1e-12; k++) out.push(k * step);
  return out;
}
