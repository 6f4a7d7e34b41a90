// Pictures of the page against those of `zonal render` for a solution of any size:
//
//     node viewer/test/compare.mjs church/church.npz nave aisle
//
// Slow for large solutions: the page is drawn by the processor. The program is that of `cargo build --release`; see `browser/support.mjs` for other places.

import { resolve } from 'node:path';
import { compareBlocks, compareSpots, launch, missing, open, rendered, serve } from './browser/support.mjs';

const [WIDTH, HEIGHT, TIMES, SAMPLES] = [320, 200, 3, 32];

const [solution, ...cameras] = process.argv.slice(2);
if (!solution || !cameras.length || missing) {
  console.error(missing || 'usage: node viewer/test/compare.mjs RUN.npz CAMERA…');
  process.exit(2);
}
const path = resolve(solution);
const server = await serve(path);
const browser = await launch();
const { page } = await open(browser, server.url, { width: WIDTH, height: HEIGHT });
page.setDefaultTimeout(600000);
const percent = (x) => `${(100 * x).toFixed(2)} %`;
for (const camera of cameras) {
  const reference = rendered(path, camera, WIDTH, HEIGHT, SAMPLES);
  const drawn = await page.evaluate(([c, w, h]) => window.zonal.linear(c, w, h), [camera, TIMES * WIDTH, TIMES * HEIGHT]);
  for (const side of [16, 8]) {
    const d = compareBlocks(reference, drawn, WIDTH, HEIGHT, TIMES, side);
    console.log(`${camera}: ${d.count} blocks of ${side} × ${side} pixels differ by ${percent(d.median)} in the median, ${percent(d.largest)} at most, ${d.over} by more than 5 %`);
  }
  for (const reach of [1, 2]) {
    const share = compareSpots(reference, drawn, WIDTH, HEIGHT, TIMES, reach);
    console.log(`${camera}: ${percent(share)} of the brightest pixels are within ${reach} pixel${reach > 1 ? 's' : ''} of those of the reference`);
  }
}
const counts = await page.evaluate(() => {
  const v = window.zonal;
  v.frame(true);
  return { ...v.renderer.counts, vertices: v.data.mesh.vertices };
});
console.log(`${counts.calls} draw calls and ${(counts.bytes / 1e6).toFixed(0)} MB of indices and vertices a frame; ${counts.vertices} vertices`);
await browser.close();
await server.stop();
