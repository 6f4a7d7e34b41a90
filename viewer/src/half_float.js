// Conversion of IEEE 754 half floats, stored in a Uint16Array.

const bits = new Float32Array(1);
const word = new Uint32Array(bits.buffer);

/** The value of each of the 65536 half floats. */
export const VALUES = (() => {
  const table = new Float32Array(65536);
  for (let h = 0; h < 65536; h++) {
    const e = (h >> 10) & 31;
    const m = h & 1023;
    const a = e === 0 ? m * 2 ** -24 : e === 31 ? Infinity : (1024 + m) * 2 ** (e - 25);
    table[h] = h & 0x8000 ? -a : a;
  }
  return table;
})();

/** The nearest half float; overflow gives the largest finite one, NaN gives zero. */
export function toHalf(x) {
  if (!(x === x)) return 0;
  bits[0] = x;
  const w = word[0];
  const sign = (w >>> 16) & 0x8000;
  const e = ((w >>> 23) & 255) - 127;
  if (e > 15) return sign | 0x7bff;
  // Rounding may carry into the exponent, up to the largest finite value.
  if (e >= -14) return sign | Math.min((((e + 15) << 10) | ((w >>> 13) & 1023)) + ((w >>> 12) & 1), 0x7bff);
  return sign | Math.round(Math.abs(bits[0]) * 2 ** 24);
}

/** Converts an array of values to half floats. */
export function toHalves(values, out = new Uint16Array(values.length)) {
  for (let i = 0; i < values.length; i++) out[i] = toHalf(values[i]);
  return out;
}
