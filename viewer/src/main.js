// The page: data in, with progress, and then the viewer or a word on why not.

import { Damaged, download, fromBase64, inflate, parse } from './blob.js';
import { Scene } from './scene.js';
import { Viewer } from './viewer.js';

const $ = (id) => document.getElementById(id);

/** Says how far loading is, or why it ended. */
function cover(title, text, share = null) {
  $('coverTitle').textContent = title;
  $('coverText').textContent = text;
  $('coverBar').hidden = share === null;
  if (share !== null) {
    $('coverBar').setAttribute('aria-valuenow', String(Math.round(100 * share)));
    $('coverBar').firstElementChild.style.width = `${100 * share}%`;
  }
}
const breath = () => new Promise((done) => setTimeout(done));

function context(canvas) {
  const gl = canvas.getContext('webgl2', { antialias: false, alpha: false, depth: false, powerPreference: 'high-performance' });
  if (!gl) throw new Damaged('This browser or device does not offer WebGL 2, which the viewer draws with. Current versions of Chrome, Edge, Firefox and Safari do; it may be switched off in their settings.');
  if (!gl.getExtension('EXT_color_buffer_float') && !gl.getExtension('EXT_color_buffer_half_float')) {
    throw new Damaged('This device cannot draw with half floats (EXT_color_buffer_float), which the viewer needs for true brightness.');
  }
  return gl;
}

async function fetched() {
  const inside = $('data');
  const tell = (share) => cover('Loading', 'Reading the solution…', 0.8 * share);
  const chunks = inside ? fromBase64(inside.textContent.trim(), tell) : await download('scene.bin', tell);
  inside?.remove();
  cover('Loading', 'Unpacking…', 0.82);
  await breath();
  return parse(await inflate(chunks));
}

async function begin() {
  const canvas = $('canvas');
  const started = performance.now();
  try {
    const gl = context(canvas);
    const data = await fetched();
    cover('Loading', `Preparing ${data.name}…`, 0.88);
    await breath();
    const small = matchMedia('(pointer: coarse)').matches;
    const scene = await Scene.load(gl, data, (s) => cover('Loading', `Preparing ${data.name}…`, 0.88 + 0.1 * s), small);
    for (const id of ['canvas', 'bar']) $(id).hidden = false;
    const viewer = new Viewer(gl, canvas, data, scene);
    if (innerWidth > 900) viewer.panel.toggle(true);
    $('cover').hidden = true;
    canvas.addEventListener('webglcontextlost', (e) => {
      e.preventDefault();
      $('cover').hidden = false;
      cover('The graphics card let go', 'Its context was lost, perhaps for want of memory. Load the page again to go on; the address keeps your view.');
    });
    viewer.loaded = performance.now() - started;
    window.zonal = viewer;
  } catch (e) {
    if (!(e instanceof Damaged)) console.error(e);
    cover(e instanceof Damaged ? 'This cannot be shown' : 'Something went wrong', e.message || String(e));
    document.body.dataset.failed = '1';
  }
}

begin();
