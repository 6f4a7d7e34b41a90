// The viewer: one state, and frames when something changes.

import { autoExposure } from './colour.js';
import * as cameras from './camera.js';
import { Controls } from './controls.js';
import { show as showCard } from './card.js';
import { add, direction, frame, mix, project, scale, sub } from './maths.js';
import { NAMES, Panel } from './panel.js';
import { probe, raycast } from './probe.js';
import { BANDS, Renderer } from './renderer.js';
import { patch } from './relight.js';
import * as hash from './hash.js';

const $ = (id) => document.getElementById(id);
const calm = matchMedia('(prefers-reduced-motion: reduce)');

export class Viewer {
  constructor(gl, canvas, data, scene) {
    Object.assign(this, { gl, canvas, data, scene });
    this.renderer = new Renderer(gl, scene);
    this.small = matchMedia('(pointer: coarse)').matches || Math.min(screen.width, screen.height) < 500;
    this.resolution = this.small ? 0.75 : 1;
    this.base = 1;
    this.pivot = mix(data.bounds[0], data.bounds[1], 0.5);
    this.hideBacks = null;
    this.state = {
      camera: this.start(), at: data.cameras.length ? 0 : 'overview', mode: data.cameras.length ? 'walk' : 'orbit', stops: 0, density: 1,
      factors: data.groups.map(() => 1), show: 'picture', band: 'mean', log: true, range: null,
    };
    this.relit = { field: null };
    this.fromHash();
    this.panel = new Panel(data, this.wishes());
    this.controls = new Controls(canvas, this.gestures());
    addEventListener('resize', () => this.changed());
    addEventListener('hashchange', () => this.fromHash() && this.changed());
    document.addEventListener('visibilitychange', () => this.changed());
    this.relight();
    this.base = this.automatic();
    this.last = 0;
    this.changed();
  }

  start() {
    const c = this.data.cameras[0];
    return c ? cameras.named(c) : cameras.overview(this.data.bounds, this.aspect());
  }

  aspect() {
    return this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
  }

  // State.

  fromHash() {
    const { origin, groups } = this.data;
    const got = hash.read(location.hash, groups);
    if (got.camera) {
      got.camera.eye = sub(got.camera.eye, origin);
      got.at = undefined;
    }
    Object.assign(this.state, got);
    if (got.factors) this.relit.field = null;
    return Object.keys(got).length > 0;
  }

  toHash() {
    const s = this.state;
    const text = hash.write({ ...s, camera: { ...s.camera, eye: add(s.camera.eye, this.data.origin) } }, this.data.groups);
    try {
      history.replaceState(null, '', text);
    } catch {
      // From a file some browsers keep the address as it is.
    }
  }

  set(change) {
    Object.assign(this.state, change);
    if ('factors' in change || 'show' in change) this.relit.field = null;
    this.changed();
  }

  wishes() {
    return {
      stops: (v) => this.set({ stops: v }),
      density: (v) => this.set({ density: v }),
      light: (i, f) => this.set({ factors: this.state.factors.map((x, k) => (k === i ? f : x)) }),
      lightsReset: () => this.set({ factors: this.state.factors.map(() => 1) }),
      show: (v) => this.set({ show: v, range: null }),
      band: (v) => this.set({ band: v, range: null }),
      log: (v) => this.set({ log: v }),
      range: (v) => this.set({ range: v }),
      mode: (v) => this.mode(v),
      camera: (i) => this.fly(i),
    };
  }

  mode(mode) {
    if (mode === 'orbit') this.aim();
    this.set({ mode });
  }

  /** The point to go about: what is in the middle of the picture. */
  aim() {
    const { eye, forward } = this.state.camera;
    const hit = raycast(this.data, eye, forward, this.backsHidden());
    const reach = this.renderer.diagonal;
    this.pivot = add(eye, scale(forward, hit ? hit.t : 0.3 * reach));
  }

  backsHidden() {
    return this.hideBacks ?? this.state.mode === 'orbit';
  }

  fly(which) {
    const c = this.data.cameras[which];
    const goal = c ? cameras.named(c) : cameras.overview(this.data.bounds, this.aspect());
    const mode = which === 'overview' ? 'orbit' : 'walk';
    if (which === 'overview') this.pivot = mix(this.data.bounds[0], this.data.bounds[1], 0.5);
    const from = cameras.copy(this.state.camera);
    this.flight = calm.matches ? null : { from, goal, begin: performance.now() };
    this.set({ at: which, mode, ...(this.flight ? {} : { camera: goal }) });
  }

  move(camera) {
    this.flight = null;
    this.set({ camera, at: undefined });
  }

  gestures() {
    const lens = () => frame(this.state.camera, this.aspect());
    return {
      changed: () => this.changed(),
      look: (dx, dy) => {
        const { tanX, tanY } = lens();
        const c = this.state.camera;
        if (this.state.mode === 'orbit') this.move(cameras.orbit(c, this.pivot, -dx * 3.2, -dy * 2.4));
        else this.move(cameras.look(c, dx * 2 * Math.atan(tanX), dy * 2 * Math.atan(tanY)));
      },
      pan: (dx, dy) => {
        const { tanX, tanY } = lens();
        const reach = this.state.mode === 'orbit' ? this.pivot : add(this.state.camera.eye, scale(this.state.camera.forward, 0.25 * this.renderer.diagonal));
        const moved = cameras.pan(this.state.camera, reach, dx, dy, tanX, tanY);
        if (this.state.mode === 'orbit') this.pivot = moved.pivot;
        this.move(moved.camera);
      },
      zoom: (factor) => {
        const c = this.state.camera;
        if (this.state.mode === 'orbit') this.move(cameras.zoom(c, this.pivot, factor));
        else this.move({ ...c, eye: add(c.eye, scale(c.forward, -Math.log(factor) * 0.25 * this.renderer.diagonal)) });
      },
      tap: (x, y) => this.probe(x, y),
      key: (code, e) => this.key(code, e),
    };
  }

  key(code, e) {
    const shows = ['picture', ...Object.keys(NAMES)];
    const digit = /^(?:Digit|Numpad)([1-9])$/.exec(code);
    if (digit) {
      if (!this.data.cameras[digit[1] - 1]) return false;
      this.fly(Number(digit[1]) - 1);
      return true;
    }
    if (e.key === '?') return $('help').showModal(), true;
    if (e.key === '+' || e.key === '=') return this.set({ stops: Math.min(this.state.stops + 0.5, 8) }), true;
    if (e.key === '-') return this.set({ stops: Math.max(this.state.stops - 0.5, -8) }), true;
    const does = {
      KeyO: () => this.mode(this.state.mode === 'walk' ? 'orbit' : 'walk'),
      KeyF: () => this.set({ show: shows[(shows.indexOf(this.state.show) + 1) % shows.length], range: null }),
      KeyM: () => this.set({ density: this.state.density > 0 ? 0 : 1 }),
      KeyB: () => {
        this.hideBacks = !this.backsHidden();
        this.changed();
      },
      KeyH: () => this.panel.toggle(),
      KeyP: () => this.probe(0.5, 0.5, true),
      Digit0: () => this.set({ factors: this.state.factors.map(() => 1) }),
      Escape: () => this.unprobe(),
    };
    does[code]?.();
    return code in does;
  }

  // Light.

  relight() {
    const field = this.state.show === 'error' ? 'error' : 'irradiance';
    if (this.relit.field === field) return;
    this.scene.relight(this.state.factors, field);
    this.relit.field = field;
    if (this.spot) this.refresh();
  }

  look(more = {}) {
    const s = this.state;
    return {
      camera: s.camera, exposure: this.base * 2 ** s.stops, density: s.density, show: s.show, band: s.band, log: s.log,
      range: s.show === 'picture' ? null : this.range(), hideBacks: this.backsHidden(), factors: s.factors, ...more,
    };
  }

  /** The exposure that `zonal render` would choose for the first camera and the lights as solved. */
  automatic() {
    const look = this.look({ camera: this.start(), exposure: 1, show: 'picture', hideBacks: false });
    const most = this.renderer.linear({ ...look, exposure: this.guess() }, 160, 120, { hazeScale: 0.5, stride: 1, steps: 48 });
    return autoExposure(most);
  }

  /** A first exposure, from the mean radiosity of the zones, so that nothing leaves the range of halves. */
  guess() {
    const v = this.values('radiosity', 'mean');
    const mean = v.reduce((s, x) => s + x, 0) / Math.max(v.length, 1);
    return mean > 0 ? 1 / mean : 1;
  }

  /** One number a patch. */
  values(show, band) {
    const w = BANDS[band];
    const n = this.data.counts.patches;
    const out = new Float32Array(n);
    for (let z = 0; z < n; z++) {
      const v = patch(this.data, z, this.state.factors)[show];
      out[z] = w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
    }
    return out;
  }

  /** Ends of the scale: as set, or those within which nearly all patches lie. */
  range() {
    const { show, band, log, range, factors } = this.state;
    if (range && !(log && range[0] <= 0)) return range;
    const key = `${show} ${band} ${factors.join(' ')}`;
    if (this.ends?.key !== key) {
      const v = this.values(show, band).filter((x) => x > 0 && Number.isFinite(x)).sort();
      const at = (q) => v[Math.floor((v.length - 1) * q)] ?? 1;
      this.ends = { key, low: at(0.05), high: at(0.995) };
    }
    const high = range ? range[1] : this.ends.high;
    const low = range ? high / 1e3 : log ? Math.max(this.ends.low, high / 1e3) : 0;
    return [low < high ? low : high / 10, high > 0 ? high : 1];
  }

  // Probe.

  probe(x, y, middle = false) {
    const dir = direction(frame(this.state.camera, this.aspect()), x, y);
    this.spot = { eye: [...this.state.camera.eye], dir, at: [x, y] };
    $('cross').hidden = !middle;
    this.refresh();
    return this.found;
  }

  refresh() {
    const { eye, dir, at: spot } = this.spot;
    const irradiance = this.state.show === 'error' ? null : this.scene.values;
    this.found = probe(this.data, irradiance ?? new Float32Array(0), this.state.factors, eye, dir, this.backsHidden());
    if (!this.found) return this.unprobe();
    if (!irradiance) this.found.here.irradiance = [NaN, NaN, NaN];
    // The radiosity there, textures and all: that of a very small picture from nearby.
    const flip = this.found.back ? -1 : 1;
    const near = 0.02 * this.renderer.diagonal;
    const camera = { eye: sub(this.found.point, scale(dir, flip * Math.min(near, this.found.distance))), forward: scale(dir, flip), up: Math.abs(dir[2]) < 0.9 ? [0, 0, 1] : [0, 1, 0], fov: 0.02 };
    if (irradiance && !this.found.back) {
      const p = this.renderer.linear(this.look({ camera, density: 0, show: 'picture', bare: true, exposure: this.guess() }), 2, 2, { hazeScale: 1, steps: 1, stride: 1 });
      this.found.here.radiosity = [p[0], p[1], p[2]].map((v) => v * Math.PI);
    }
    const card = $('probe');
    showCard(card, this.found, () => this.unprobe());
    // Not over the point itself.
    card.classList.toggle('above', spot[1] > 0.45);
    card.classList.toggle('aside', spot[1] > 0.4 && spot[0] < 0.4);
    document.body.classList.add('probing');
    this.changed();
    return this.found;
  }

  unprobe() {
    this.spot = null;
    this.found = null;
    $('probe').hidden = true;
    $('mark').hidden = true;
    $('cross').hidden = true;
    document.body.classList.remove('probing');
    return null;
  }

  placeMark() {
    if (!this.found) return;
    const box = this.canvas.getBoundingClientRect();
    const at = project(frame(this.state.camera, box.width / box.height), this.state.camera.eye, this.found.point);
    const seen = at && at.every((x) => x > 0 && x < 1);
    $('mark').hidden = !seen;
    if (seen) {
      $('mark').style.left = `${at[0] * box.width}px`;
      $('mark').style.top = `${at[1] * box.height}px`;
    }
  }

  // Frames.

  changed() {
    this.stillAt = performance.now() + 160;
    this.dirty = true;
    if (!this.asked) {
      this.asked = true;
      requestAnimationFrame((now) => this.tick(now));
    }
  }

  /** Moves what moves by itself; true while something does. */
  advance(now) {
    const seconds = Math.min((now - this.last) / 1000, 0.1);
    if (this.flight) {
      const t = Math.min((now - this.flight.begin) / 700, 1);
      this.state.camera = cameras.between(this.flight.from, this.flight.goal, Math.max(t, 0));
      if (t >= 1) this.flight = null;
      return true;
    }
    if (!this.controls.active) return false;
    const w = this.controls.wishes();
    const pace = 0.07 * this.renderer.diagonal * (this.controls.fast ? 4 : 1) * seconds;
    let c = cameras.look(this.state.camera, w.turn * 1.4 * seconds, w.tilt * 1.0 * seconds);
    if (this.state.mode === 'orbit') {
      c = cameras.orbit(this.state.camera, this.pivot, (w.right - w.turn) * 1.2 * seconds, -(w.up + w.tilt) * seconds);
      c = cameras.zoom(c, this.pivot, Math.exp(-w.ahead * seconds));
    } else {
      c = cameras.walk(c, w.ahead * pace, w.right * pace, w.up * pace);
    }
    Object.assign(this.state, { camera: c, at: undefined });
    return true;
  }

  tick(now) {
    this.asked = false;
    if (this.gl.isContextLost()) return;
    const moving = this.advance(now);
    this.last = now;
    const still = !moving && performance.now() >= this.stillAt;
    this.frame(still);
    if (moving) this.changed();
    else if (!still) {
      // A fine picture once nothing moves any more.
      clearTimeout(this.settle);
      this.settle = setTimeout(() => {
        this.asked = true;
        requestAnimationFrame((t) => this.tick(t));
      }, 180);
    } else this.toHash();
  }

  frame(still) {
    const ratio = Math.min(devicePixelRatio || 1, this.small ? 1.5 : 2) * (still ? 1 : this.resolution);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    const begin = performance.now();
    this.relight();
    const look = this.look();
    this.renderer.draw(look, width, height, this.quality(still, width * height));
    this.panel.update(this.state, look.range);
    this.placeMark();
    if (!still) this.pace(performance.now() - begin);
    this.frames = (this.frames ?? 0) + 1;
  }

  /** Steps through the medium and the size of its picture. */
  quality(still, pixels) {
    const fine = this.small ? 0.5 : 1;
    if (!still) return { hazeScale: this.small ? 0.25 : 0.4, steps: 48 * fine, stride: 1.2 };
    return { hazeScale: pixels < 2e5 ? 1 : 0.5, steps: 160 * fine, stride: 0.5 };
  }

  /** Fewer pixels while moving where frames take long, more where they do not. */
  pace(spent) {
    // Commands only queue; every few frames their true time is asked for.
    if ((this.frames ?? 0) % 6 === 0) {
      const begin = performance.now();
      this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
      const all = spent + performance.now() - begin;
      if (all > 45) this.resolution = Math.max(0.3, this.resolution * 0.8);
      else if (all < 14) this.resolution = Math.min(1, this.resolution * 1.15);
    }
  }

  /** For tests and scripts: linear radiance of a camera, W/(m² sr), row 0 on top, three floats a pixel. */
  linear(name, width, height) {
    this.relight();
    const c = this.data.cameras.find((x) => x.name === name);
    const camera = c ? cameras.named(c) : this.state.camera;
    const raw = this.renderer.linear(this.look({ camera, show: 'picture', hideBacks: false }), width, height, { hazeScale: 1, steps: 256, stride: 0.5, jitter: -1 });
    const out = [];
    for (let y = height - 1; y >= 0; y--) {
      for (let x = 0; x < width; x++) out.push(...raw.subarray(4 * (y * width + x), 4 * (y * width + x) + 3));
    }
    this.changed();
    return out;
  }
}
