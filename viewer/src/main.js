// Entry point: loads the data with a progress bar, then starts the viewer or shows the reason of a failure.

import { UnusableError, download, fromBase64, inflate, parse } from './data_package.js';
import { describe, follow, isSameScene, waitForData } from './live.js';
import { Scene } from './scene.js';
import { Viewer } from './viewer.js';

const $ = (id) => document.getElementById(id);

/** Shows the progress of loading, or the reason of a failure. */
function showStatus(title, text, fraction = null) {
  $('coverTitle').textContent = title;
  $('coverText').textContent = text;
  $('coverBar').hidden = fraction === null;
  if (fraction !== null) {
    $('coverBar').setAttribute('aria-valuenow', String(Math.round(100 * fraction)));
    $('coverBar').firstElementChild.style.width = `${100 * fraction}%`;
  }
}
/** Lets the browser draw. */
const yieldToBrowser = () => new Promise((done) => setTimeout(done));

function context(canvas) {
  const gl = canvas.getContext('webgl2', { antialias: false, alpha: false, depth: false, powerPreference: 'high-performance' });
  if (!gl) throw new UnusableError('The viewer needs WebGL 2, which this browser or device does not provide. Current versions of Chrome, Edge, Firefox and Safari do, unless it is disabled in their settings.');
  if (!gl.getExtension('EXT_color_buffer_float') && !gl.getExtension('EXT_color_buffer_half_float')) {
    throw new UnusableError('The viewer needs half-float render targets (EXT_color_buffer_float), which this device does not provide.');
  }
  return gl;
}

/** Reads the data package: from the page itself, or from the server, which may still have to compute it. Returns also the progress of the server. */
async function loadData() {
  const embedded = $('data');
  const report = (fraction) => showStatus('Loading', 'Reading the solution…', 0.8 * fraction);
  const progress = embedded ? null : await waitForData((p) => showStatus('Solving', describe(p), p.fraction));
  if (progress?.version === 0) throw new UnusableError(progress.error);
  const chunks = embedded ? fromBase64(embedded.textContent.trim(), report) : await download('scene.bin', report);
  embedded?.remove();
  showStatus('Loading', 'Decompressing…', 0.82);
  await yieldToBrowser();
  return { data: parse(await inflate(chunks)), progress };
}

/** Follows the solve behind the page: shows its progress, and new data in place of the old ones. */
function followSolve(viewer, version, small) {
  const show = (line) => {
    $('solving').textContent = line;
    $('solving').hidden = !line;
  };
  const replace = async () => {
    const data = parse(await inflate(await download('scene.bin')));
    // The address keeps the view across a reload.
    if (!isSameScene(viewer.data, data)) return location.reload();
    viewer.replace(data, await Scene.load(viewer.gl, data, () => {}, small));
    viewer.version = (viewer.version ?? version) + 1;
  };
  follow(version, show, replace).catch((e) => show(e.message || String(e)));
}

/** Starts the viewer. */
async function start() {
  const canvas = $('canvas');
  const started = performance.now();
  try {
    const gl = context(canvas);
    const { data, progress } = await loadData();
    showStatus('Loading', `Preparing ${data.name}…`, 0.88);
    await yieldToBrowser();
    const small = matchMedia('(pointer: coarse)').matches;
    const scene = await Scene.load(gl, data, (s) => showStatus('Loading', `Preparing ${data.name}…`, 0.88 + 0.1 * s), small);
    for (const id of ['canvas', 'bar']) $(id).hidden = false;
    const viewer = new Viewer(gl, canvas, data, scene);
    if (innerWidth > 900) viewer.panel.toggle(true);
    $('cover').hidden = true;
    canvas.addEventListener('webglcontextlost', (e) => {
      e.preventDefault();
      $('cover').hidden = false;
      showStatus('Graphics context lost', 'The graphics card may be out of memory. Reload the page to continue; the address keeps the view.');
    });
    viewer.loaded = performance.now() - started;
    window.zonal = viewer;
    if (progress?.live) followSolve(viewer, progress.version, small);
  } catch (e) {
    if (!(e instanceof UnusableError)) console.error(e);
    showStatus(e instanceof UnusableError ? 'The solution cannot be shown' : 'Unexpected error', e.message || String(e));
    document.body.dataset.failed = '1';
  }
}

start();
