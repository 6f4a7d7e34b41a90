// The settings panel. It shows a state and reports changes by callbacks; it holds no state.

import { cssColour } from './colour.js';
import { MIN_STOPS, count, fromSlider, number, percent, relativeError, stops, ticks, multiplier, toSlider } from './format.js';

const $ = (id) => document.getElementById(id);

/** The stages of a solve without exchange of light. */
const FIRST_STAGES = ['sunlight', 'direct light'];

export const NAMES = { irradiance: 'Irradiance', radiosity: 'Radiosity', error: 'Error estimate of the irradiance' };
const BAND_NAMES = { mean: 'mean of bands', luminance: 'luminance', red: 'red band', green: 'green band', blue: 'blue band' };

/** Fills the track of a slider between its centre and its thumb. */
function fill(input) {
  const { min, max, value } = input;
  const at = (100 * (value - min)) / (max - min);
  input.style.setProperty('--from', `${Math.min(at, 50)}%`);
  input.style.setProperty('--to', `${Math.max(at, 50)}%`);
}

/** Shows a value on a slider and its output. */
function showSlider(input, output, position, text, changed) {
  input.value = position;
  input.setAttribute('aria-valuetext', text);
  output.textContent = text;
  output.classList.toggle('changed', changed);
  fill(input);
}

/** `on` has one callback a setting, with its new value. */
export class Panel {
  constructor(data, on) {
    this.data = data;
    this.on = on;
    $('title').textContent = data.name;
    document.title = `${data.name} · zonal`;
    this.cameras(data.cameras);
    this.lights(data.groups);
    this.report(data);
    $('densityRow').hidden = !data.volume;
    $('exposure').addEventListener('input', (e) => on.stops(Number(e.target.value)));
    $('density').addEventListener('input', (e) => on.density(fromSlider(Number(e.target.value))));
    for (const [id, value] of [['exposure', () => on.stops(0)], ['density', () => on.density(1)]]) $(id).addEventListener('dblclick', value);
    $('saveCamera').addEventListener('click', () => on.saveCamera());
    $('copyCamera').addEventListener('click', () => on.copyCamera());
    $('lightsReset').addEventListener('click', () => on.lightsReset());
    $('show').addEventListener('change', (e) => on.show(e.target.value));
    $('band').addEventListener('change', (e) => on.band(e.target.value));
    $('part').addEventListener('change', (e) => on.part(e.target.value));
    $('log').addEventListener('click', () => on.log(true));
    $('linear').addEventListener('click', () => on.log(false));
    $('rangeReset').addEventListener('click', () => on.range(null));
    for (const id of ['low', 'high']) $(id).addEventListener('change', () => this.readRange());
    for (const mode of ['walk', 'orbit']) $(mode).addEventListener('click', () => on.mode(mode));
    $('panelButton').addEventListener('click', () => this.toggle());
    $('helpButton').addEventListener('click', () => $('help').showModal());
  }

  cameras(cameras) {
    const select = $('camera');
    const add = (text, value) => select.append(Object.assign(document.createElement('option'), { textContent: text, value }));
    cameras.forEach((c, i) => add(c.name, i));
    add('overview', 'overview');
    add('free', 'free');
    select.addEventListener('change', () => select.value !== 'free' && this.on.camera(select.value === 'overview' ? 'overview' : Number(select.value)));
  }

  lights(groups) {
    groups.forEach((g, i) => {
      const row = document.createElement('div');
      row.className = 'slider light';
      const id = `light${i}`;
      const label = Object.assign(document.createElement('label'), { htmlFor: id, textContent: g.name, title: g.name });
      const output = Object.assign(document.createElement('output'), { id: `${id}Out`, htmlFor: id });
      const input = Object.assign(document.createElement('input'), { type: 'range', id, min: MIN_STOPS, max: -MIN_STOPS, step: 0.1 });
      input.addEventListener('input', () => this.on.light(i, fromSlider(Number(input.value))));
      input.addEventListener('dblclick', () => this.on.light(i, 1));
      row.append(label, output, input);
      $('lights').append(row);
    });
  }

  report({ counts, report }) {
    for (const id of ['report', 'warnings']) $(id).replaceChildren();
    const row = (name, value) => {
      $('report').append(Object.assign(document.createElement('dt'), { textContent: name }), Object.assign(document.createElement('dd'), { textContent: value }));
    };
    row('Patches', count(counts.patches));
    if (counts.voxels) row('Volume zones', count(counts.voxels));
    if (counts.panes) row('Pane zones', count(counts.panes));
    row('Engine', report.engine);
    row('Solver status', report.status);
    // The errors of all solutions of the series, the newest last.
    const errors = (kind) => report.estimates.map((e) => relativeError(e[kind])).join(' → ');
    row('RMS error of H', errors('patches'));
    if (counts.voxels || counts.panes) row('RMS error of G', errors('volumes'));
    row('Grade of factors', report.grade);
    if (!FIRST_STAGES.includes(report.stage)) row('Energy residual', percent(Math.max(...report.residual.map(Math.abs))));
    for (const { severity, text, advice } of report.notes) {
      const item = Object.assign(document.createElement('li'), { className: severity, textContent: text });
      if (advice) item.append(Object.assign(document.createElement('p'), { textContent: advice }));
      $('warnings').append(item);
    }
  }

  /** Reads the two inputs of the range. */
  readRange() {
    const [low, high] = ['low', 'high'].map((id) => Number($(id).value.replace(',', '.')));
    const valid = Number.isFinite(low) && Number.isFinite(high) && high > low && low >= 0;
    for (const id of ['low', 'high']) $(id).setAttribute('aria-invalid', String(!valid));
    if (valid) this.on.range([low, high]);
  }

  /** Says what became of the options of a camera. */
  showCopied(text) {
    $('copied').textContent = text;
    $('copied').hidden = false;
  }

  toggle(open = $('panel').hidden) {
    $('panel').hidden = !open;
    document.body.classList.toggle('panel', open);
    $('panelButton').setAttribute('aria-expanded', String(open));
  }

  /** Shows a state. */
  update(state, ends) {
    showSlider($('exposure'), $('exposureOut'), state.stops, stops(state.stops), state.stops !== 0);
    showSlider($('density'), $('densityOut'), toSlider(state.density), multiplier(state.density), state.density !== 1);
    state.factors.forEach((f, i) => showSlider($(`light${i}`), $(`light${i}Out`), toSlider(f), multiplier(f), f !== 1));
    $('lightsReset').disabled = state.factors.every((f) => f === 1);
    for (const input of document.getElementsByName('show')) input.checked = input.value === state.show;
    const mapped = state.show !== 'picture';
    $('mapSettings').hidden = !mapped;
    $('pictureSettings').hidden = mapped;
    $('band').value = state.band;
    $('part').value = state.part;
    $('partRow').hidden = state.show === 'error';
    $('log').setAttribute('aria-pressed', String(state.log));
    $('linear').setAttribute('aria-pressed', String(!state.log));
    for (const mode of ['walk', 'orbit']) $(mode).setAttribute('aria-pressed', String(state.mode === mode));
    $('camera').value = state.activeCamera ?? 'free';
    if (mapped) this.legend(state, ends);
    $('legend').hidden = !mapped;
    document.body.classList.toggle('mapped', mapped);
  }

  legend(state, [low, high]) {
    if (document.activeElement !== $('low')) $('low').value = number(low, 3);
    if (document.activeElement !== $('high')) $('high').value = number(high, 3);
    const name = state.part === 'total' || state.show === 'error' ? NAMES[state.show] : `${NAMES[state.show]} of ${state.part} light`;
    $('legendTitle').replaceChildren(name, Object.assign(document.createElement('span'), { textContent: ` · ${BAND_NAMES[state.band]} · W/m²` }));
    $('legendBar').style.background = `linear-gradient(90deg in srgb, ${Array.from({ length: 33 }, (_, i) => cssColour(i / 32)).join(', ')})`;
    if (!$('legendBar').style.background) $('legendBar').style.background = `linear-gradient(90deg, ${Array.from({ length: 33 }, (_, i) => cssColour(i / 32)).join(', ')})`;
    const position = (x) => (state.log ? Math.log(x / low) / Math.log(high / low) : (x - low) / (high - low));
    let last = -1;
    const marks = ticks(low, high, state.log).filter((x) => {
      const keep = position(x) - last > 0.11;
      if (keep) last = position(x);
      return keep;
    });
    $('legendTicks').replaceChildren(...marks.map((x) => {
      const s = Object.assign(document.createElement('span'), { textContent: number(x, 3).replace(/(\.\d*?)0+$/, '$1').replace(/\.$/, '') });
      s.style.left = `${100 * position(x)}%`;
      return s;
    }));
  }
}
