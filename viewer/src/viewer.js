// The viewer: holds the state, handles input, and draws a frame when something changes.

import { autoExposure } from './colour.js';
import * as cameras from './camera.js';
import { cameraFile, cameraOptions, copy, save } from './camera_file.js';
import { Controls } from './controls.js';
import { showProbe } from './probe_card.js';
import { add, direction, frame, mix, project, scale, sub } from './vector_math.js';
import { NAMES, Panel } from './panel.js';
import { probe, raycast } from './probe.js';
import { BAND_WEIGHTS, Renderer } from './renderer.js';
import { partOf, patchFields } from './relight.js';
import * as urlState from './url_state.js';

const $ = (id) => document.getElementById(id);
const reducedMotion = matchMedia('(prefers-reduced-motion: reduce)');

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
      camera: this.initialCamera(), activeCamera: data.cameras.length ? 0 : 'overview', mode: data.cameras.length ? 'walk' : 'orbit', stops: 0, density: 1,
      factors: data.groups.map(() => 1), show: 'picture', part: 'total', band: 'mean', log: true, range: null,
    };
    this.relit = { field: null };
    this.readUrl();
    this.panel = new Panel(data, this.panelActions());
    this.controls = new Controls(canvas, this.inputActions());
    addEventListener('resize', () => this.changed());
    addEventListener('hashchange', () => this.readUrl() && this.changed());
    document.addEventListener('visibilitychange', () => this.changed());
    this.relight();
    this.base = this.automaticExposure();
    this.last = 0;
    this.changed();
  }

  /** Shows other data of the same scene with the same settings. */
  replace(data, scene) {
    this.scene.free();
    Object.assign(this, { data, scene, ends: null });
    this.renderer.show(scene);
    this.panel.report(data);
    this.relit.field = null;
    this.relight();
    this.base = this.automaticExposure();
    this.changed();
  }

  initialCamera() {
    const c = this.data.cameras[0];
    return c ? cameras.fromScene(c) : cameras.overview(this.data.bounds, this.aspect());
  }

  aspect() {
    return this.canvas.clientWidth / Math.max(this.canvas.clientHeight, 1);
  }

  // State.

  /** Applies the settings in the URL; true where there are any. */
  readUrl() {
    const { origin, groups } = this.data;
    const settings = urlState.read(location.hash, groups);
    if (settings.camera) {
      settings.camera.eye = sub(settings.camera.eye, origin);
      settings.activeCamera = undefined;
    }
    Object.assign(this.state, settings);
    if (settings.factors) this.relit.field = null;
    return Object.keys(settings).length > 0;
  }

  writeUrl() {
    const s = this.state;
    const text = urlState.write({ ...s, camera: { ...s.camera, eye: add(s.camera.eye, this.data.origin) } }, this.data.groups);
    try {
      history.replaceState(null, '', text);
    } catch {
      // Some browsers do not allow this for local files.
    }
  }

  set(change) {
    Object.assign(this.state, change);
    if ('factors' in change || 'show' in change || 'part' in change) this.relit.field = null;
    this.changed();
  }

  panelActions() {
    return {
      stops: (v) => this.set({ stops: v }),
      density: (v) => this.set({ density: v }),
      light: (i, f) => this.set({ factors: this.state.factors.map((x, k) => (k === i ? f : x)) }),
      lightsReset: () => this.set({ factors: this.state.factors.map(() => 1) }),
      show: (v) => this.set({ show: v, range: null }),
      part: (v) => this.set({ part: v, range: null }),
      band: (v) => this.set({ band: v, range: null }),
      log: (v) => this.set({ log: v }),
      range: (v) => this.set({ range: v }),
      mode: (v) => this.setMode(v),
      camera: (i) => this.flyTo(i),
      saveCamera: () => save('camera.toml', cameraFile(this.sceneCamera())),
      copyCamera: async () => {
        const options = cameraOptions(this.sceneCamera());
        this.panel.showCopied((await copy(options)) ? `Copied: ${options}` : options);
      },
    };
  }

  /** The camera in the coordinates of the scene. It looks at the surface in the centre of the picture, or ahead. */
  sceneCamera() {
    const { eye, forward, up } = this.state.camera;
    const hit = raycast(this.data, eye, forward, this.backsHidden());
    const target = add(eye, scale(forward, hit ? hit.t : 0.3 * this.renderer.diagonal));
    const { tanX } = frame(this.state.camera, this.aspect());
    const fov = (360 / Math.PI) * Math.atan(tanX);
    return { origin: add(eye, this.data.origin), target: add(target, this.data.origin), up, fov };
  }

  setMode(mode) {
    if (mode === 'orbit') this.choosePivot();
    this.set({ mode });
  }

  /** Takes the surface point in the centre of the picture as the pivot of orbits. */
  choosePivot() {
    const { eye, forward } = this.state.camera;
    const hit = raycast(this.data, eye, forward, this.backsHidden());
    const { diagonal } = this.renderer;
    this.pivot = add(eye, scale(forward, hit ? hit.t : 0.3 * diagonal));
  }

  backsHidden() {
    return this.hideBacks ?? this.state.mode === 'orbit';
  }

  /** Moves smoothly to a camera of the scene, or to the overview. */
  flyTo(which) {
    const c = this.data.cameras[which];
    const goal = c ? cameras.fromScene(c) : cameras.overview(this.data.bounds, this.aspect());
    const mode = which === 'overview' ? 'orbit' : 'walk';
    if (which === 'overview') this.pivot = mix(this.data.bounds[0], this.data.bounds[1], 0.5);
    const from = cameras.copy(this.state.camera);
    this.flight = reducedMotion.matches ? null : { from, goal, begin: performance.now() };
    this.set({ activeCamera: which, mode, ...(this.flight ? {} : { camera: goal }) });
  }

  move(camera) {
    this.flight = null;
    this.set({ camera, activeCamera: undefined });
  }

  inputActions() {
    const frustum = () => frame(this.state.camera, this.aspect());
    return {
      changed: () => this.changed(),
      look: (dx, dy) => {
        const { tanX, tanY } = frustum();
        const c = this.state.camera;
        if (this.state.mode === 'orbit') this.move(cameras.orbit(c, this.pivot, -dx * 3.2, -dy * 2.4));
        else this.move(cameras.look(c, dx * 2 * Math.atan(tanX), dy * 2 * Math.atan(tanY)));
      },
      pan: (dx, dy) => {
        const { tanX, tanY } = frustum();
        const target = this.state.mode === 'orbit' ? this.pivot : add(this.state.camera.eye, scale(this.state.camera.forward, 0.25 * this.renderer.diagonal));
        const moved = cameras.pan(this.state.camera, target, dx, dy, tanX, tanY);
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
      this.flyTo(Number(digit[1]) - 1);
      return true;
    }
    if (e.key === '?') return $('help').showModal(), true;
    if (e.key === '+' || e.key === '=') return this.set({ stops: Math.min(this.state.stops + 0.5, 8) }), true;
    if (e.key === '-') return this.set({ stops: Math.max(this.state.stops - 0.5, -8) }), true;
    const actions = {
      KeyO: () => this.setMode(this.state.mode === 'walk' ? 'orbit' : 'walk'),
      KeyF: () => this.set({ show: shows[(shows.indexOf(this.state.show) + 1) % shows.length], range: null }),
      KeyM: () => this.set({ density: this.state.density > 0 ? 0 : 1 }),
      KeyB: () => {
        this.hideBacks = !this.backsHidden();
        this.changed();
      },
      KeyH: () => this.panel.toggle(),
      KeyP: () => this.probe(0.5, 0.5, true),
      Digit0: () => this.set({ factors: this.state.factors.map(() => 1) }),
      Escape: () => this.closeProbe(),
    };
    actions[code]?.();
    return code in actions;
  }

  // Light.

  relight() {
    const { show, part } = this.state;
    const field = show === 'error' ? 'error' : show === 'picture' ? 'total' : part;
    if (this.relit.field === field) return;
    this.scene.relight(this.state.factors, field);
    this.relit.field = field;
    if (this.probeRay) this.updateProbe();
  }

  /** Settings of a frame. */
  frameSettings(more = {}) {
    const s = this.state;
    return {
      camera: s.camera, exposure: this.base * 2 ** s.stops, density: s.density, show: s.show, part: s.part, band: s.band, log: s.log,
      range: s.show === 'picture' ? null : this.range(), hideBacks: this.backsHidden(), factors: s.factors, ...more,
    };
  }

  /** The exposure that `zonal render` chooses for the first camera and the lights as solved. */
  automaticExposure() {
    const settings = this.frameSettings({ camera: this.initialCamera(), exposure: 1, show: 'picture', hideBacks: false });
    const pixels = this.renderer.linear({ ...settings, exposure: this.provisionalExposure() }, 160, 120, { mediumScale: 0.5, stride: 1, steps: 48 });
    return autoExposure(pixels);
  }

  /** A provisional exposure from the mean radiosity of the zones, so that radiances stay in the range of half floats. */
  provisionalExposure() {
    const v = this.patchValues('radiosity', 'mean');
    const mean = v.reduce((s, x) => s + x, 0) / Math.max(v.length, 1);
    return mean > 0 ? 1 / mean : 1;
  }

  /** One number a patch. */
  patchValues(show, band, part = 'total') {
    const w = BAND_WEIGHTS[band];
    const n = this.data.counts.patches;
    const out = new Float32Array(n);
    for (let z = 0; z < n; z++) {
      const v = partOf(patchFields(this.data, z, this.state.factors), show, part);
      out[z] = w[0] * v[0] + w[1] * v[1] + w[2] * v[2];
    }
    return out;
  }

  /** Ends of the scale: as set, or percentiles of the patches. */
  range() {
    const { show, part, band, log, range, factors } = this.state;
    if (range && !(log && range[0] <= 0)) return range;
    const key = `${show} ${part} ${band} ${factors.join(' ')}`;
    if (this.ends?.key !== key) {
      const v = this.patchValues(show, band, part).filter((x) => x > 0 && Number.isFinite(x)).sort();
      const at = (q) => v[Math.floor((v.length - 1) * q)] ?? 1;
      this.ends = { key, low: at(0.05), high: at(0.995) };
    }
    const high = range ? range[1] : this.ends.high;
    const low = range ? high / 1e3 : log ? Math.max(this.ends.low, high / 1e3) : 0;
    return [low < high ? low : high / 10, high > 0 ? high : 1];
  }

  // Probe.

  probe(x, y, inCentre = false) {
    const dir = direction(frame(this.state.camera, this.aspect()), x, y);
    this.probeRay = { eye: [...this.state.camera.eye], dir, at: [x, y] };
    $('cross').hidden = !inCentre;
    this.updateProbe();
    return this.probeResult;
  }

  updateProbe() {
    const { eye, dir, at } = this.probeRay;
    this.probeResult = probe(this.data, this.state.factors, eye, dir, this.backsHidden());
    if (!this.probeResult) return this.closeProbe();
    const { here } = this.probeResult;
    // Sunlight at the point, and its radiosity with textures: render very small pictures from nearby.
    const side = this.probeResult.back ? -1 : 1;
    const near = 0.02 * this.renderer.diagonal;
    const camera = { eye: sub(this.probeResult.point, scale(dir, side * Math.min(near, this.probeResult.distance))), forward: scale(dir, side), up: Math.abs(dir[2]) < 0.9 ? [0, 0, 1] : [0, 1, 0], fov: 0.02 };
    const draw = (more) => {
      const settings = this.frameSettings({ camera, density: 0, withoutPanes: true, exposure: this.provisionalExposure(), ...more });
      return [...this.renderer.linear(settings, 2, 2, { mediumScale: 1, steps: 1, stride: 1, sunSamples: 256 }).subarray(0, 3)];
    };
    if (this.scene.suns.count) here.direct = add(here.direct, draw({ show: 'irradiance', part: 'sun' }));
    here.irradiance = add(here.indirect, here.direct);
    if (this.relit.field === 'total' && !this.probeResult.back) here.radiosity = draw({ show: 'picture' }).map((v) => v * Math.PI);
    const card = $('probe');
    showProbe(card, this.probeResult, () => this.closeProbe());
    // Keep the card off the point.
    card.classList.toggle('above', at[1] > 0.45);
    card.classList.toggle('aside', at[1] > 0.4 && at[0] < 0.4);
    document.body.classList.add('probing');
    this.changed();
    return this.probeResult;
  }

  closeProbe() {
    this.probeRay = null;
    this.probeResult = null;
    $('probe').hidden = true;
    $('mark').hidden = true;
    $('cross').hidden = true;
    document.body.classList.remove('probing');
    return null;
  }

  placeMark() {
    if (!this.probeResult) return;
    const box = this.canvas.getBoundingClientRect();
    const at = project(frame(this.state.camera, box.width / box.height), this.state.camera.eye, this.probeResult.point);
    const visible = at && at.every((x) => x > 0 && x < 1);
    $('mark').hidden = !visible;
    if (visible) {
      $('mark').style.left = `${at[0] * box.width}px`;
      $('mark').style.top = `${at[1] * box.height}px`;
    }
  }

  // Frames.

  changed() {
    this.restAt = performance.now() + 160;
    this.dirty = true;
    if (!this.frameRequested) {
      this.frameRequested = true;
      requestAnimationFrame((now) => this.tick(now));
    }
  }

  /** Advances flights and held keys; true while the camera moves. */
  advance(now) {
    const seconds = Math.min((now - this.last) / 1000, 0.1);
    if (this.flight) {
      const t = Math.min((now - this.flight.begin) / 700, 1);
      this.state.camera = cameras.interpolate(this.flight.from, this.flight.goal, Math.max(t, 0));
      if (t >= 1) this.flight = null;
      return true;
    }
    if (!this.controls.active) return false;
    const m = this.controls.motion();
    const distance = 0.07 * this.renderer.diagonal * (this.controls.fast ? 4 : 1) * seconds;
    let c = cameras.look(this.state.camera, m.yaw * 1.4 * seconds, m.pitch * 1.0 * seconds);
    if (this.state.mode === 'orbit') {
      c = cameras.orbit(this.state.camera, this.pivot, (m.right - m.yaw) * 1.2 * seconds, -(m.up + m.pitch) * seconds);
      c = cameras.zoom(c, this.pivot, Math.exp(-m.ahead * seconds));
    } else {
      c = cameras.walk(c, m.ahead * distance, m.right * distance, m.up * distance);
    }
    Object.assign(this.state, { camera: c, activeCamera: undefined });
    return true;
  }

  tick(now) {
    this.frameRequested = false;
    if (this.gl.isContextLost()) return;
    const moving = this.advance(now);
    this.last = now;
    const still = !moving && performance.now() >= this.restAt;
    this.frame(still);
    if (moving) this.changed();
    else if (!still) {
      // Draw at full quality once the camera is at rest.
      clearTimeout(this.restTimer);
      this.restTimer = setTimeout(() => {
        this.frameRequested = true;
        requestAnimationFrame((t) => this.tick(t));
      }, 180);
    } else this.writeUrl();
  }

  frame(still) {
    const ratio = Math.min(devicePixelRatio || 1, this.small ? 1.5 : 2) * (still ? 1 : this.resolution);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    if (this.canvas.width !== width || this.canvas.height !== height) Object.assign(this.canvas, { width, height });
    const begin = performance.now();
    this.relight();
    const settings = this.frameSettings();
    this.renderer.draw(settings, width, height, this.quality(still, width * height));
    this.panel.update(this.state, settings.range);
    this.placeMark();
    if (!still) this.adaptResolution(performance.now() - begin);
    this.frames = (this.frames ?? 0) + 1;
  }

  /** Steps through the medium and the scale of its render target. */
  quality(still, pixels) {
    const fine = this.small ? 0.5 : 1;
    if (!still) return { mediumScale: this.small ? 0.25 : 0.4, steps: 48 * fine, stride: 1.2, sunSamples: 8 };
    return { mediumScale: pixels < 2e5 ? 1 : 0.5, steps: 160 * fine, stride: 0.5, sunSamples: this.small ? 16 : 32 };
  }

  /** Adapts the resolution during motion to the frame time. */
  adaptResolution(spent) {
    // Commands are queued: every few frames wait for them to measure the true time.
    if ((this.frames ?? 0) % 6 === 0) {
      const begin = performance.now();
      this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
      const total = spent + performance.now() - begin;
      if (total > 45) this.resolution = Math.max(0.3, this.resolution * 0.8);
      else if (total < 14) this.resolution = Math.min(1, this.resolution * 1.15);
    }
  }

  /** For tests and scripts: linear radiance of a camera, W/(m² sr), row 0 on top, three floats a pixel. */
  linear(name, width, height) {
    this.relight();
    const c = this.data.cameras.find((x) => x.name === name);
    const camera = c ? cameras.fromScene(c) : this.state.camera;
    const raw = this.renderer.linear(this.frameSettings({ camera, show: 'picture', hideBacks: false }), width, height, { mediumScale: 0.5, steps: 256, stride: 0.5, jitter: -1 });
    const out = [];
    for (let y = height - 1; y >= 0; y--) {
      for (let x = 0; x < width; x++) out.push(...raw.subarray(4 * (y * width + x), 4 * (y * width + x) + 3));
    }
    this.changed();
    return out;
  }
}
