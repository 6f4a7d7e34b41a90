// The samples of examples/threejs in a browser: their pictures against `zonal render`.
// Guards (pictures): the pictures of `examples/threejs` agree with `zonal render` (run by CI).

import test from 'node:test';
import assert from 'node:assert/strict';
import { createServer } from 'node:http';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { extname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { compareBlocks, complaints, file, folder, launch, missing, rendered, run } from './support.mjs';

const samples = fileURLToPath(new URL('../../../examples/threejs/', import.meta.url));
const modules = fileURLToPath(new URL('../../node_modules/', import.meta.url));
const TYPES = { '.html': 'text/html', '.js': 'text/javascript', '.json': 'application/json' };

/** A file server of the samples, the exports and the modules. */
const files = () => new Promise((done) => {
  const server = createServer((request, answer) => {
    const path = decodeURIComponent(new URL(request.url, 'http://localhost').pathname);
    const places = [join(samples, path), join(folder, path), join(modules, path.replace('/node_modules/', '/'))];
    const found = places.find((p) => existsSync(p));
    answer.writeHead(found ? 200 : 404, { 'Content-Type': TYPES[extname(path)] ?? 'application/octet-stream' });
    answer.end(found ? readFileSync(found) : '');
  }).listen(0, '127.0.0.1', () => done(server));
});

/** A room with a lamp and a table. */
const ROOM = `[solve]
patch_size = 0.25
[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [4, 3, 2.5] }
reflectance = [0.7, 0.65, 0.5]
faces.x0 = { reflectance = [0.7, 0.2, 0.1] }
[[surface]]
name = "lamp"
rectangle = { origin = [1.5, 1, 2.4], edge1 = [0, 1, 0], edge2 = [1, 0, 0] }
emission = 20
[[surface]]
name = "table"
box = { min = [2.4, 1.4, 0], max = [3.4, 2.6, 0.8] }
reflectance = 0.5
[[camera]]
name = "door"
origin = [0.3, 0.2, 1.6]
target = [3, 2.2, 0.7]
fov = 70
`;

/** A room with a luminous ceiling; with a ball in its middle, or none. */
const softRoom = (ball) => `[solve]
patch_size = 0.5
[[surface]]
name = "room"
room = { min = [0, 0, 0], max = [4, 3, 2.5] }
reflectance = [0.8, 0.7, 0.6]
faces.z1 = { emission = 5 }
${ball ? `[[surface]]
name = "ball"
mesh = { file = "ball.obj" }
reflectance = 0.95
[[camera]]
name = "ball"
origin = [2, ${1.5 - 4 * RADIUS}, 1.25]
target = [2, 1.5, 1.25]
fov = 40
` : ''}`;
const RADIUS = 0.05 * Math.hypot(4, 3, 2.5);

/** A ball of quadrangles as OBJ. */
function ball(columns = 20, rows = 10) {
  const lines = [];
  for (let j = 0; j <= rows; j++) {
    for (let i = 0; i < columns; i++) {
      const [t, p] = [(Math.PI * j) / rows, (2 * Math.PI * i) / columns];
      lines.push(`v ${2 + RADIUS * Math.sin(t) * Math.cos(p)} ${1.5 + RADIUS * Math.sin(t) * Math.sin(p)} ${1.25 + RADIUS * Math.cos(t)}`);
    }
  }
  for (let j = 0; j < rows; j++) {
    for (let i = 0; i < columns; i++) {
      const at = (y, x) => 1 + y * columns + (x % columns);
      if (j + 1 < rows) lines.push(`f ${at(j, i)} ${at(j + 1, i)} ${at(j + 1, i + 1)}`);
      if (j > 0) lines.push(`f ${at(j, i)} ${at(j + 1, i + 1)} ${at(j, i + 1)}`);
    }
  }
  return lines.join('\n');
}

/** The radiance of a sample's picture, row 0 on top. */
const linear = (page, width, height) => page.evaluate(([w, h]) => {
  const { THREE, renderer, scene, camera } = window.sample;
  const target = new THREE.WebGLRenderTarget(w, h, { type: THREE.FloatType });
  camera.aspect = w / h;
  camera.updateProjectionMatrix();
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  const all = new Float32Array(4 * w * h);
  renderer.readRenderTargetPixels(target, 0, 0, w, h, all);
  renderer.setRenderTarget(null);
  const out = [];
  for (let y = h - 1; y >= 0; y--) for (let x = 4 * y * w; x < 4 * (y + 1) * w; x++) if (x % 4 < 3) out.push(all[x]);
  return out;
}, [width, height]);

test('samples', { skip: missing || !existsSync(join(modules, 'three')) }, async (t) => {
  writeFileSync(file('ball.obj'), ball());
  for (const [name, text] of [['room', ROOM], ['soft', softRoom(false)], ['soft_ball', softRoom(true)]]) {
    writeFileSync(file(`${name}.toml`), text);
    run('solve', `${name}.toml`, '-o', `${name}.npz`, '--quiet');
  }
  run('export', 'room.npz', '-o', 'room.glb', '--lightmap', '--texel', '0.02');
  run('export', 'soft.npz', '-o', 'room.volume.json', '--irradiance-volume', '--grid', '16,12,10');
  const [server, browser] = [await files(), await launch()];
  const open = async (sample) => {
    const page = await (await browser.newContext({ viewport: { width: 240, height: 180 } })).newPage();
    const said = [];
    page.on('console', (m) => ['error', 'warning'].includes(m.type()) && said.push(m.text()));
    page.on('pageerror', (e) => said.push(String(e)));
    await page.goto(`http://127.0.0.1:${server.address().port}/${sample}`);
    await page.waitForFunction(() => window.sample, null, { timeout: 30000 });
    assert.deepEqual(complaints(said).filter((s) => !/favicon|404/.test(s)), []);
    if (process.env.KEEP) await page.screenshot({ path: join(process.env.KEEP, `${sample.split('.')[0]}.png`) });
    return page;
  };

  await t.test('a lightmap shows the radiance of zonal render', async () => {
    const [w, h, times] = [160, 120, 2];
    const page = await open('lightmap.html');
    const found = compareBlocks(rendered('room.npz', 'door', w, h, 4), await linear(page, times * w, times * h), w, h, times);
    t.diagnostic(`lightmap: blocks differ by ${(100 * found.median).toFixed(2)} % (median), ${(100 * found.largest).toFixed(2)} % at most`);
    // zonal render corrects the interpolated irradiance near contacts, by the table's foot.
    assert.ok(found.median < 0.005 && found.over <= 15 && found.largest < 0.15, JSON.stringify(found));
  });

  await t.test('an irradiance volume lights a ball as in a solution with that ball', async () => {
    const [w, h, times] = [96, 96, 2];
    const page = await open('irradiance_volume.html');
    // A white ball hardly changes the light of the room.
    await page.evaluate(() => window.sample.ball.material.uniforms.colour.value.fill(0.95));
    const [reference, fine] = [rendered('soft_ball.npz', 'ball', w, h, 4), await linear(page, times * w, times * h)];
    // Only pixels in the ball's disk: the page has no room around it.
    const inside = (i) => Math.hypot((i % w) - w / 2 + 0.5, Math.floor(i / w) - h / 2 + 0.5) < 0.3 * w;
    const [sum, off, bias] = [[0, 0, 0], [0, 0, 0], [0, 0, 0]];
    for (let i = 0; i < w * h; i++) {
      if (!inside(i)) continue;
      for (let k = 0; k < 3; k++) {
        let mean = 0;
        for (let n = 0; n < times * times; n++) {
          const [x, y] = [(i % w) * times + (n % times), Math.floor(i / w) * times + Math.floor(n / times)];
          mean += fine[3 * (y * w * times + x) + k] / (times * times);
        }
        sum[k] += reference[3 * i + k];
        off[k] += Math.abs(mean - reference[3 * i + k]);
        bias[k] += mean - reference[3 * i + k];
      }
    }
    const [shares, means] = [off, bias].map((list) => list.map((x, k) => x / sum[k]));
    t.diagnostic(`irradiance volume: mean difference of ${shares.map((s) => (100 * s).toFixed(1)).join(', ')} %, of the means ${means.map((s) => (100 * s).toFixed(1)).join(', ')} %`);
    // Exact harmonics of degree 1 differ by 4, 6 and 8 % here: they smooth the light.
    assert.ok(Math.max(...shares) < 0.1 && Math.max(...means.map(Math.abs)) < 0.09, `${shares} ${means}`);
  });

  await browser.close();
  server.close();
});
