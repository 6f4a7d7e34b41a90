// Numbers for people.

/** Four significant digits, with powers of ten where a number would be long. */
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

/** Metres, to a millimetre or a millionth of the scene. */
export const metres = (x) => x.toFixed(Math.abs(x) < 1000 ? 3 : 1);

/** A count with thin spaces. */
export const count = (n) => String(n).replace(/\B(?=(\d{3})+$)/g, '\u202f');

/** Per cent with two digits. */
export const percent = (x) => `${x === 0 ? '0' : x < 1e-5 ? '<\u20090.001' : (100 * x).toPrecision(2).replace(/\.0+$/, '')}\u2009%`;

/** Size of data. */
export const bytes = (n) => (n < 1e6 ? `${Math.ceil(n / 1e3)}\u2009kB` : `${(n / 1e6).toFixed(1)}\u2009MB`);

/** A factor as on a light's slider: off, or times so much. */
export const times = (f) => (f === 0 ? 'off' : `×\u2009${f >= 100 ? f.toFixed(0) : f.toPrecision(f >= 1 ? 3 : 2).replace(/\.?0+$/, '')}`);

/** Stops with their sign. */
export const stops = (s) => `${s > 0 ? '+' : s < 0 ? '−' : ''}${Math.abs(s).toFixed(1)}\u2009EV`;

/** A slider's place in stops for a factor, and back; the lowest place is zero. */
export const LOWEST = -8;
export const toPlace = (f) => (f <= 2 ** (LOWEST + 0.05) ? LOWEST : Math.min(Math.log2(f), -LOWEST));
export const fromPlace = (p) => (p <= LOWEST + 1e-9 ? 0 : 2 ** p);

/** Values between the ends of a scale where numbers may stand: round ones. */
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
