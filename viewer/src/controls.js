// Mouse, touch and keys on the canvas, translated to camera motion.

/** Motion of held keys: ahead, right, up, yaw to the left, pitch upwards. */
const HELD_KEYS = {
  KeyW: ['ahead', 1], ArrowUp: ['ahead', 1], KeyS: ['ahead', -1], ArrowDown: ['ahead', -1],
  KeyA: ['right', -1], KeyD: ['right', 1], KeyE: ['up', 1], KeyQ: ['up', -1],
  ArrowLeft: ['yaw', 1], ArrowRight: ['yaw', -1], PageUp: ['pitch', 1], PageDown: ['pitch', -1],
};

/** True where a key belongs to a form control. */
const isFormControl = (e) => e.target.closest?.('input, select, textarea, button');

export class Controls {
  /** `on` has: look(dx, dy), pan(dx, dy), zoom(factor), tap(x, y), key(code, event), changed(). Coordinates are fractions of the canvas. */
  constructor(canvas, on) {
    this.canvas = canvas;
    this.on = on;
    this.held = new Set();
    this.fast = false;
    this.pointers = new Map();
    canvas.addEventListener('pointerdown', (e) => this.down(e));
    canvas.addEventListener('pointermove', (e) => this.move(e));
    for (const end of ['pointerup', 'pointercancel']) canvas.addEventListener(end, (e) => this.up(e));
    canvas.addEventListener('wheel', (e) => this.wheel(e), { passive: false });
    canvas.addEventListener('contextmenu', (e) => e.preventDefault());
    addEventListener('keydown', (e) => this.keydown(e));
    addEventListener('keyup', (e) => {
      this.held.delete(e.code);
      this.fast = e.shiftKey;
    });
    addEventListener('blur', () => this.held.clear());
  }

  keydown(e) {
    this.fast = e.shiftKey;
    if (e.target.closest?.('dialog')) return;
    if (e.ctrlKey || e.metaKey || e.altKey || (isFormControl(e) && e.key !== 'Escape')) return;
    if (HELD_KEYS[e.code]) {
      e.preventDefault();
      this.held.add(e.code);
      this.on.changed();
    } else if (this.on.key(e.code, e)) {
      e.preventDefault();
    }
  }

  /** The motion of the held keys, each component from -1 to 1. */
  motion() {
    const out = { ahead: 0, right: 0, up: 0, yaw: 0, pitch: 0 };
    for (const code of this.held) out[HELD_KEYS[code][0]] += HELD_KEYS[code][1];
    return out;
  }
  get active() {
    return this.held.size > 0;
  }

  at(e) {
    const box = this.canvas.getBoundingClientRect();
    return [(e.clientX - box.left) / box.width, (e.clientY - box.top) / box.height];
  }

  down(e) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(e.pointerId);
    this.pointers.set(e.pointerId, { at: this.at(e), start: this.at(e), second: e.button === 2 || e.button === 1 || e.shiftKey });
    this.moved = this.pointers.size > 1;
  }

  move(e) {
    const p = this.pointers.get(e.pointerId);
    if (!p) return;
    const before = [...this.pointers.values()].map((q) => q.at);
    const was = p.at;
    p.at = this.at(e);
    const distance = Math.hypot((p.at[0] - p.start[0]) * this.canvas.clientWidth, (p.at[1] - p.start[1]) * this.canvas.clientHeight);
    if (distance > 5) this.moved = true;
    if (!this.moved) return;
    if (this.pointers.size === 1) {
      (p.second ? this.on.pan : this.on.look)(p.at[0] - was[0], p.at[1] - was[1]);
    } else if (this.pointers.size === 2) {
      const after = [...this.pointers.values()].map((q) => q.at);
      const spread = ([a, b]) => Math.hypot((a[0] - b[0]) * this.canvas.clientWidth, (a[1] - b[1]) * this.canvas.clientHeight);
      const middle = ([a, b], k) => (a[k] + b[k]) / 2;
      this.on.pan(middle(after, 0) - middle(before, 0), middle(after, 1) - middle(before, 1));
      this.on.zoom(spread(before) / Math.max(spread(after), 1));
    }
    this.on.changed();
  }

  up(e) {
    const p = this.pointers.get(e.pointerId);
    this.pointers.delete(e.pointerId);
    if (p && !this.moved && e.type === 'pointerup' && e.button === 0) this.on.tap(...p.at);
    this.on.changed();
  }

  wheel(e) {
    e.preventDefault();
    const lines = e.deltaMode === 1 ? 16 : 1;
    this.on.zoom(Math.exp(Math.min(Math.max(e.deltaY * lines, -120), 120) * 0.0015));
    this.on.changed();
  }
}
