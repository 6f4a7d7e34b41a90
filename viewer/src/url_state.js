// Camera and settings in the fragment of the URL, so that a view can be bookmarked and shared.

const round = (x) => Number(x.toPrecision(6));
const list = (v) => v.map(round).join(',');

/** The URL fragment of a state; default values are omitted. */
export function write(state, groups) {
  const { camera: c } = state;
  const p = new URLSearchParams();
  p.set('eye', list(c.eye));
  p.set('to', list(c.forward));
  if (c.up[2] !== 1) p.set('up', list(c.up));
  p.set('fov', round(c.fov));
  if (state.mode !== 'walk') p.set('mode', state.mode);
  if (state.stops) p.set('ev', round(state.stops));
  if (state.density !== 1) p.set('density', round(state.density));
  if (state.show !== 'picture') p.set('show', state.show);
  if (state.part !== 'total') p.set('part', state.part);
  if (state.band !== 'mean') p.set('band', state.band);
  if (!state.log) p.set('scale', 'linear');
  if (state.range) p.set('range', list(state.range));
  groups.forEach((g, i) => {
    if (state.factors[i] !== 1) p.set(`light.${g.name}`, round(state.factors[i]));
  });
  return `#${p.toString().replaceAll('%2C', ',')}`;
}

/** The settings in a fragment; invalid ones are omitted. */
export function read(fragment, groups) {
  const p = new URLSearchParams(fragment.replace(/^#/, ''));
  const numbers = (key, n) => {
    const v = (p.get(key) ?? '').split(',').map((x) => (x.trim() === '' ? NaN : Number(x)));
    return v.length === n && v.every((x) => Number.isFinite(x) && Math.abs(x) < 1e30) ? v : null;
  };
  const number = (key, low, high) => {
    const v = numbers(key, 1);
    return v && v[0] >= low && v[0] <= high ? v[0] : null;
  };
  const word = (key, words) => (words.includes(p.get(key)) ? p.get(key) : null);
  const out = {};
  const eye = numbers('eye', 3);
  const forward = numbers('to', 3);
  const norm = (v) => Math.hypot(...v);
  if (eye && forward && norm(forward) > 0) {
    const up = numbers('up', 3) ?? [0, 0, 1];
    const unit = (v) => v.map((x) => x / (norm(v) || 1));
    const [f, u] = [unit(forward), unit(up)];
    const cosine = Math.abs(f[0] * u[0] + f[1] * u[1] + f[2] * u[2]);
    if (norm(up) > 0 && cosine < 0.99999) out.camera = { eye, forward: f, up: u, fov: number('fov', 1, 150) ?? 60 };
  }
  const set = (key, value) => {
    if (value !== null) out[key] = value;
  };
  set('mode', word('mode', ['walk', 'orbit']));
  set('stops', number('ev', -30, 30));
  set('density', number('density', 0, 1000));
  set('show', word('show', ['picture', 'irradiance', 'radiosity', 'error']));
  set('part', word('part', ['total', 'direct', 'indirect']));
  set('band', word('band', ['mean', 'luminance', 'red', 'green', 'blue']));
  if (p.get('scale') === 'linear') out.log = false;
  const range = numbers('range', 2);
  if (range && range[1] > range[0]) out.range = range;
  const factors = groups.map((g) => number(`light.${g.name}`, 0, 1e6));
  if (factors.some((f) => f !== null)) out.factors = factors.map((f) => f ?? 1);
  return out;
}
