// Radiances of the page against `zonal render`, `zonal relight` and the solution.
// Guards (pictures): the page agrees with `zonal render` to 5 % in blocks of 8 × 8 pixels, also relit, and its probe shows the values of the solution
//     (run by CI).

import test from 'node:test';
import assert from 'node:assert/strict';
import { chapel, compareBlocks, compareSpots, launch, missing, open, rendered, run, serve, zones } from './support.mjs';

const [WIDTH, HEIGHT, TIMES] = [160, 120, 4];

test('light', { skip: missing }, async (t) => {
  const solution = chapel();
  const server = await serve(solution);
  const browser = await launch();
  const { page } = await open(browser, server.url, { width: 320, height: 240 });
  const linear = (camera) => page.evaluate(([c, w, h]) => window.zonal.linear(c, w, h), [camera, TIMES * WIDTH, TIMES * HEIGHT]);

  const compare = async (name, file, camera) => {
    const [reference, page] = [rendered(file, camera, WIDTH, HEIGHT), await linear(camera)];
    const spots = compareSpots(reference, page, WIDTH, HEIGHT, TIMES);
    t.diagnostic(`${name}: ${(100 * spots).toFixed(1)} % of the brightest pixels are within two pixels of those of the reference`);
    assert.ok(spots > 0.99, `${name}: ${spots}`);
    const large = compareBlocks(reference, page, WIDTH, HEIGHT, TIMES, 16);
    t.diagnostic(`${name}: blocks of 16 × 16 pixels differ by ${(100 * large.median).toFixed(2)} % in the median, ${(100 * large.largest).toFixed(1)} % at most`);
    const d = compareBlocks(reference, page, WIDTH, HEIGHT, TIMES);
    const line = `${name}: blocks differ by ${(100 * d.median).toFixed(2)} % in the median, ${(100 * d.largest).toFixed(1)} % at most, ${d.over} of ${d.count} by more than 5 %`;
    t.diagnostic(line);
    assert.ok(d.median < 0.01 && d.over === 0, line);
  };

  for (const camera of ['nave', 'aisle']) {
    await t.test(`camera ${camera} agrees with zonal render`, () => compare(camera, solution, camera));
  }

  await t.test('sliders agree with zonal relight', async () => {
    await page.locator('#panelButton').click();
    await page.locator('#light0').fill('-2');
    await page.locator('#light1').fill('1');
    assert.deepEqual(await page.evaluate(() => window.zonal.state.factors), [0.25, 2]);
    run('relight', solution, 'sun=0.25', 'surroundings=2', '-o', 'relit.npz');
    await compare('relit', 'relit.npz', 'nave');
    await page.locator('#lightsReset').click();
    assert.deepEqual(await page.evaluate(() => window.zonal.state.factors), [1, 1]);
    await page.locator('#panelButton').click();
  });

  await t.test('the maps of the sun are drawn once', async () => {
    const counts = await page.evaluate(() => {
      const v = window.zonal;
      v.set({ factors: [0.5, 1], stops: 1 });
      v.frame(true);
      v.set({ factors: [1, 1], stops: 0 });
      v.frame(true);
      const { drawn, side, bytes, count } = v.scene.suns;
      return { drawn, side, bytes, count, frame: v.renderer.counts, data: v.data.mesh.vertices };
    });
    t.diagnostic(`${counts.frame.calls} draw calls and ${counts.frame.bytes} bytes of indices and vertices a frame; ${counts.data} vertices; ${counts.count} map(s) of the sun, ${counts.side} texels a side, ${counts.bytes} bytes, drawn once`);
    assert.deepEqual([counts.drawn, counts.count], [1, 1]);
    assert.ok(counts.frame.calls > 0 && counts.frame.calls < 200, `${counts.frame.calls}`);
  });

  await t.test('direct and indirect irradiance sum to the total', async () => {
    const [total, direct, indirect] = await page.evaluate(() => ['total', 'direct', 'indirect'].map((part) => {
      const v = window.zonal;
      v.set({ show: 'irradiance', part });
      v.relight();
      return [...v.renderer.linear(v.frameSettings(), 80, 60, v.quality(true, 4800))];
    }));
    await page.evaluate(() => window.zonal.set({ show: 'picture', part: 'total' }));
    const most = Math.max(...total);
    let sunlit = 0;
    total.forEach((x, i) => {
      if (i % 4 === 3) return;
      assert.ok(Math.abs(x - direct[i] - indirect[i]) < 4e-3 * x + 1e-4 * most, `${x} ${direct[i]} ${indirect[i]}`);
      sunlit += direct[i] > 0.5 * x;
    });
    assert.ok(sunlit > 20, `${sunlit} pixels in direct light`);
  });

  // The rows of the probe card.
  const card = () => page.evaluate(() => {
    const rows = {};
    let group = '';
    for (const tr of document.querySelectorAll('#probe tbody tr')) {
      const name = tr.querySelector('th').textContent;
      if (tr.className === 'group') group = name;
      else rows[`${group}: ${name}`] = [...tr.querySelectorAll('td')].map((td) => Number(td.textContent));
    }
    return { rows, zone: window.zonal.probeResult.zone, text: document.getElementById('probe').textContent };
  });
  const near = (shown, expected, digits = 6e-4) => shown.forEach((x, b) => assert.ok(Math.abs(x - expected[b]) <= digits * Math.abs(expected[b]) + 1e-12, `${shown} ${expected}`));
  const three = (row, name) => [0, 1, 2].map((b) => row[`${name}_${b}`]);

  const checkCard = async (file) => {
    const { rows, zone, text } = await card();
    const row = zones(file)[zone];
    assert.equal(row.kind, 'patch');
    assert.ok(text.includes(row.of) && text.includes('W/m²'), text);
    near(rows['mean of the zone: Radiosity'], three(row, 'radiosity'));
    near(rows['mean of the zone: indirect'], three(row, 'incident'));
    near(rows['mean of the zone: direct'], three(row, 'direct'));
    near(rows['mean of the zone: Irradiance'], three(row, 'incident').map((x, b) => x + row[`direct_${b}`]));
    return { rows, row };
  };

  await t.test('probe shows the values of the solution', async () => {
    await page.evaluate(() => window.zonal.flyTo(0));
    await page.waitForFunction(() => !window.zonal.flight);
    for (const [x, y] of [[160, 200], [60, 120], [250, 90]]) {
      await page.mouse.click(x, y);
      const { rows, row } = await checkCard(solution);
      near(rows['mean of the zone: error'], three(row, 'error').map((e, b) => e + row[`direct_error_${b}`]));
      // At the point B = E + ρ (H + H_dir), here without emission or textures.
      const rho = await page.evaluate(() => window.zonal.data.surfaces.find((s) => s.name === window.zonal.probeResult.surface).reflectance);
      near(rows['at this point: Radiosity'], rows['at this point: Irradiance'].map((h, b) => h * rho[b]), 4e-3);
      near(rows['at this point: Irradiance'], rows['at this point: indirect'].map((h, b) => h + rows['at this point: direct'][b]), 2e-3);
      await page.keyboard.press('Escape');
      assert.equal(await page.locator('#probe').isVisible(), false);
    }
  });

  await t.test('probe follows the sliders', async () => {
    await page.locator('#canvas').focus();
    await page.keyboard.press('p');
    await page.evaluate(() => window.zonal.set({ factors: [0.25, 2] }));
    await page.waitForFunction(() => window.zonal.relit.field);
    await checkCard('relit.npz');
    await page.keyboard.press('0');
  });

  await t.test('server ends cleanly on an interrupt', async () => {
    await browser.close();
    assert.equal(await server.stop(), 0);
  });
});
