// Chromium, the program and a small solution for the tests; the tests are skipped where one is missing.

import { execFileSync, spawn } from 'node:child_process';
import { accessSync, constants, copyFileSync, existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { delimiter, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = fileURLToPath(new URL('../../../', import.meta.url));
// BUILT: the folder of the program, if it is not that of `cargo build --release`; CHAPEL: the small demo's solution, if it is there already.
const built = resolve(root, process.env.BUILT ?? join(process.env.CARGO_TARGET_DIR ?? 'target', 'release'));
const zonal = join(built, 'zonal');
const floats = join(built, 'examples/floats');

function inPath(names) {
  for (const folder of (process.env.PATH ?? '').split(delimiter)) {
    for (const name of names) {
      const path = join(folder, name);
      try {
        accessSync(path, constants.X_OK);
        return path;
      } catch {
        // Not here.
      }
    }
  }
  return null;
}

const chromiumPath = process.env.CHROMIUM ?? inPath(['chromium', 'chromium-browser', 'google-chrome']);

/** The reason to skip the tests; an error on the CI. */
export const missing = (() => {
  const lacks = [
    [existsSync(zonal) && existsSync(floats), 'cargo build --release --bin zonal --example floats'],
    [chromiumPath, 'chromium'],
    [existsSync(join(root, 'viewer/node_modules/playwright-core')), 'npm ci in viewer/'],
  ].filter(([there]) => !there);
  if (lacks.length && process.env.CI) throw new Error(`missing: ${lacks.map((l) => l[1]).join(', ')}`);
  return lacks.length ? `missing: ${lacks.map((l) => l[1]).join(', ')}` : false;
})();

export const folder = mkdtempSync(join(tmpdir(), 'zonal-viewer-'));
export const file = (name) => join(folder, name);
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));

/** Runs the program and returns its standard output. */
export const run = (...args) => execFileSync(zonal, args, { cwd: folder, encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });

/** The demo's small chapel, solved once a test file. */
export function chapel() {
  if (!existsSync(file('chapel.npz')) && process.env.CHAPEL) copyFileSync(process.env.CHAPEL, file('chapel.npz'));
  if (!existsSync(file('chapel.npz'))) run('demo', 'chapel', '--size', 'small', '-o', '.');
  return 'chapel.npz';
}

/** A server of a solution: its address, and a function that stops it. */
export async function serve(solution) {
  const child = spawn(zonal, ['view', solution, '--port', '0'], { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  let said = '';
  const url = await new Promise((done, fail) => {
    child.stdout.on('data', (d) => {
      said += d;
      const found = /http:\S+/.exec(said);
      if (found) done(found[0]);
    });
    child.on('exit', (code) => fail(new Error(`zonal view ended with ${code}`)));
  });
  const stop = () => new Promise((done) => {
    child.on('exit', (code) => done(code));
    child.kill('SIGINT');
  });
  return { url, stop };
}

/** A browser with software rendering. */
export async function launch() {
  const { chromium } = await import('playwright-core');
  return chromium.launch({
    executablePath: chromiumPath,
    args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist', '--disable-dev-shm-usage'],
  });
}

/** A page with the viewer, loaded; `said` has its warnings and errors, `asked` the requested addresses. */
export async function open(browser, url, { width = 160, height = 120, loaded = true, before = null, ...context } = {}) {
  const page = await (await browser.newContext({ viewport: { width, height }, ...context })).newPage();
  const said = [];
  const asked = [];
  page.on('console', (m) => ['error', 'warning'].includes(m.type()) && said.push(m.text()));
  page.on('pageerror', (e) => said.push(String(e)));
  page.on('request', (r) => asked.push(r.url()));
  if (before) await page.addInitScript(before);
  await page.goto(url);
  await page.waitForFunction(() => window.zonal || document.body.dataset.failed, null, { timeout: 120000 });
  if (loaded) await page.waitForFunction(() => window.zonal, null, { timeout: 10000 });
  return { page, said, asked };
}

/** Warnings without those of software rasterisers. */
export const complaints = (said) => said.filter((s) => !/GPU stall|software (WebGL|rendering)|swiftshader/i.test(s));

/** Standard deviation of the brightness of a frame, 0 to 255. */
export const spread = (page) => page.evaluate(() => {
  const v = window.zonal;
  v.frame(true);
  const { width, height } = v.canvas;
  const bytes = new Uint8Array(4 * width * height);
  v.gl.bindFramebuffer(v.gl.FRAMEBUFFER, null);
  v.gl.readPixels(0, 0, width, height, v.gl.RGBA, v.gl.UNSIGNED_BYTE, bytes);
  let [n, sum, squares] = [0, 0, 0];
  for (let i = 0; i < bytes.length; i += 4) {
    const y = (bytes[i] + bytes[i + 1] + bytes[i + 2]) / 3;
    n++;
    sum += y;
    squares += y * y;
  }
  return Math.sqrt(Math.max(0, squares / n - (sum / n) ** 2));
});

/** `zonal render` of a camera as linear floats, row 0 on top. */
export function rendered(solution, camera, width, height, samples = 64) {
  run('render', solution, '--camera', camera, '--size', `${width}x${height}`, '--samples', String(samples), '-o', 'reference.exr');
  return floatsOf('reference.exr');
}

/** The values of an .exr file, row 0 on top. */
export function floatsOf(name) {
  execFileSync(floats, [name, 'floats.npy'], { cwd: folder });
  const bytes = readFileSync(file('floats.npy'));
  const start = 10 + bytes.readUInt16LE(8);
  return new Float64Array(bytes.buffer.slice(bytes.byteOffset + start, bytes.byteOffset + bytes.length));
}

/** Mean colours of the square blocks that lie in the picture as a whole. */
function blocks(pixels, width, height, side) {
  const out = [];
  for (let y = 0; y + side <= height; y += side) {
    for (let x = 0; x + side <= width; x += side) {
      const sum = [0, 0, 0];
      for (let j = 0; j < side; j++) {
        for (let i = 0; i < side; i++) {
          for (let b = 0; b < 3; b++) sum[b] += pixels[3 * ((y + j) * width + x + i) + b] / (side * side);
        }
      }
      out.push(sum);
    }
  }
  return out;
}

/** Means of the bands of the pixels of a picture that is `times` as fine along each axis. */
const means = (pixels, width, height, times) => blocks(pixels, times * width, times * height, times).map(([r, g, b]) => (r + g + b) / 3);

/**
 * Positions of bright pixels of a reference (spots of the sun) in a picture that is `times` as fine: the share of the brightest pixels of each picture that has
 * one of the other, at 0.8 times its brightness, within `reach` pixels.
 */
export function compareSpots(reference, fine, width, height, times, reach = 2, part = 0.015) {
  const pictures = [means(reference, width, height, 1), means(fine, width, height, times)];
  const share = ([a, b]) => {
    const least = [...a].sort((x, y) => y - x)[Math.floor(part * a.length)];
    let [bright, met] = [0, 0];
    a.forEach((v, i) => {
      if (v < least) return;
      bright++;
      const [x, y] = [i % width, Math.floor(i / width)];
      let near = false;
      for (let v2 = Math.max(y - reach, 0); v2 <= Math.min(y + reach, height - 1); v2++) {
        for (let u = Math.max(x - reach, 0); u <= Math.min(x + reach, width - 1); u++) near ||= b[v2 * width + u] >= 0.8 * v;
      }
      met += near;
    });
    return met / bright;
  };
  return Math.min(share(pictures), share([...pictures].reverse()));
}

/**
 * Differences of the mean colours of blocks of `side` × `side` pixels in linear radiance: for each block the largest difference of a band over the
 * largest band of the reference. `fine` has `times` as many pixels along each axis, so that antialiasing of edges does not count.
 */
export function compareBlocks(reference, fine, width, height, times, side = 8) {
  const a = blocks(reference, width, height, side);
  const b = blocks(fine, times * width, times * height, side * times);
  const all = a.map((r, i) => Math.max(...r.map((x, k) => Math.abs(b[i][k] - x))) / Math.max(...r)).sort((x, y) => x - y);
  return { median: all[all.length >> 1], largest: all[all.length - 1], over: all.filter((x) => x > 0.05).length, count: all.length };
}

/** The rows of the table of zones. */
export function zones(solution) {
  run('export', solution, '-o', 'zones.csv');
  const [head, ...rows] = readFileSync(file('zones.csv'), 'utf8').trim().split('\n').map((l) => l.split(','));
  return rows.map((r) => Object.fromEntries(head.map((name, i) => [name, Number.isNaN(Number(r[i])) ? r[i] : Number(r[i])])));
}
