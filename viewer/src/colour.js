// From radiance to display colours: the tone curve and the colour map of `zonal render`.

const KNEE = 0.25;
export const LUMINANCE = [0.2126, 0.7152, 0.0722];

/** The tone curve: identity below the knee, a rational shoulder above. */
export function curve(x) {
  if (!(x > 0)) return 0;
  if (x <= KNEE) return x;
  const t = (x - KNEE) / (1 - KNEE);
  return t === Infinity ? 1 : KNEE + ((1 - KNEE) * t) / (1 + t);
}

/** The sRGB transfer curve. */
export function srgb(x) {
  if (x <= 0.0031308) return 12.92 * x;
  return x >= 1 ? 1 : 1.055 * x ** (1 / 2.4) - 0.055;
}

/** Automatic exposure of a linear RGBA picture: the rule of `zonal render`. */
export function autoExposure(pixels) {
  const l = [];
  for (let i = 0; i < pixels.length; i += 4) {
    const y = LUMINANCE[0] * pixels[i] + LUMINANCE[1] * pixels[i + 1] + LUMINANCE[2] * pixels[i + 2];
    if (y > 0 && Number.isFinite(y)) l.push(y);
  }
  if (!l.length) return 1;
  l.sort((a, b) => a - b);
  const at = (q) => Math.floor((l.length - 1) * q);
  const middle = l.slice(at(0.02), at(0.98) + 1);
  const mean = Math.exp(middle.reduce((s, x) => s + Math.log(x), 0) / middle.length);
  const bright = l[at(0.9)];
  const e = Math.min(Math.max(0.18 / mean, 0.18 / bright), 1.6 / bright);
  return Number.isFinite(e) && e > 0 ? e : 1;
}

/** Oklab to linear sRGB. */
export function oklab([L, a, b]) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
}

/**
 * Stations of the colour map in Oklab: lightness, chroma, hue in degrees. Lightness increases monotonically, from dark violet through
 * blue and green to light yellow, so that the map is readable in grey and with any colour vision. Between stations the map is linear and
 * parametrised by arc length, so that equal steps of the value look equal.
 */
export const STATIONS = [
  [0.24, 0.1, 300],
  [0.36, 0.13, 285],
  [0.48, 0.1, 252],
  [0.58, 0.09, 210],
  [0.68, 0.115, 165],
  [0.78, 0.15, 140],
  [0.87, 0.17, 118],
  [0.95, 0.13, 104],
];

const points = STATIONS.map(([L, c, h]) => [L, c * Math.cos((h * Math.PI) / 180), c * Math.sin((h * Math.PI) / 180)]);
const distance = (p, q) => Math.hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]);
const arcLengths = points.reduce((list, p, i) => [...list, i ? list[i - 1] + distance(points[i - 1], p) : 0], []);

/** Oklab colour of the map at t, 0 to 1. */
export function mapLab(t) {
  const s = Math.min(Math.max(t, 0), 1) * arcLengths[arcLengths.length - 1];
  let i = 1;
  while (i < arcLengths.length - 1 && arcLengths[i] < s) i++;
  const f = (s - arcLengths[i - 1]) / (arcLengths[i] - arcLengths[i - 1]);
  return [0, 1, 2].map((k) => points[i - 1][k] + f * (points[i][k] - points[i - 1][k]));
}

/** Linear colour of the map at t, clamped to the sRGB gamut. */
export function mapColour(t) {
  return oklab(mapLab(t)).map((x) => Math.min(Math.max(x, 0), 1));
}

/** Colour of the map at t as a CSS colour. */
export function cssColour(t) {
  return `rgb(${mapColour(t).map((x) => Math.round(255 * srgb(x))).join(' ')})`;
}
