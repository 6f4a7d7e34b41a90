// The page in a browser: loading, keys, gestures, narrow windows, one file without a server, and error messages.

import test from 'node:test';
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { chapel, complaints, file, floatsOf, launch, missing, open, run, serve, spread } from './support.mjs';

const camera = (page) => page.evaluate(() => window.zonal.state.camera);
const far = (a, b) => Math.hypot(...a.map((x, k) => x - b[k]));

test('page', { skip: missing }, async (t) => {
  const solution = chapel();
  const server = await serve(solution);
  const browser = await launch();
  const { page, said, asked } = await open(browser, server.url, { width: 200, height: 150 });

  await t.test('page loads without warnings, requests only its server, and draws', async () => {
    assert.deepEqual(complaints(said), []);
    assert.deepEqual([...new Set(asked.map((u) => new URL(u).origin))].filter((o) => o !== 'null'), [new URL(server.url).origin]);
    assert.ok((await spread(page)) > 20);
    assert.equal(await page.title(), 'chapel · zonal');
    t.diagnostic(`loaded in ${Math.round(await page.evaluate(() => window.zonal.loaded))} ms; data ${readFileSync(file(solution)).length} bytes as npz`);
  });

  await t.test('keys walk and turn, faster with Shift', async () => {
    const hold = async (...keys) => {
      await page.evaluate(() => window.zonal.flyTo(0));
      await page.waitForFunction(() => !window.zonal.flight);
      await page.locator('#canvas').focus();
      const before = await camera(page);
      const frames = await page.evaluate(() => window.zonal.frames);
      for (const k of keys) await page.keyboard.down(k);
      await page.waitForFunction((n) => window.zonal.frames >= n + 6, frames);
      for (const k of keys) await page.keyboard.up(k);
      await page.waitForFunction(() => !window.zonal.controls.active);
      return [before, await camera(page)];
    };
    const [a, b] = await hold('w');
    assert.ok(b.eye[1] > a.eye[1] + 1e-2 && Math.abs(b.eye[2] - a.eye[2]) < 1e-9, `ahead and level: ${a.eye} ${b.eye}`);
    const [c, d] = await hold('Shift', 'W');
    assert.ok(far(c.eye, d.eye) > 1.5 * far(a.eye, b.eye), 'faster');
    const [e, f] = await hold('ArrowRight');
    assert.ok(f.forward[0] > e.forward[0] + 1e-2 && far(e.eye, f.eye) < 1e-9, 'turned to the right');
    const [g, h] = await hold('e');
    assert.ok(h.eye[2] > g.eye[2], 'up');
  });

  await t.test('keys change settings except in form controls', async () => {
    const state = () => page.evaluate(() => ({ ...window.zonal.state, hash: location.hash }));
    await page.keyboard.press('f');
    assert.equal((await state()).show, 'irradiance');
    await page.waitForFunction(() => !document.getElementById('legend').hidden);
    const legend = await page.locator('#legend').innerText();
    assert.ok(legend.includes('Irradiance') && legend.includes('W/m²') && /\d/.test(legend), legend);
    assert.ok((await spread(page)) > 10);
    for (let i = 0; i < 3; i++) await page.keyboard.press('f');
    await page.keyboard.press('+');
    assert.deepEqual([(await state()).show, (await state()).stops], ['picture', 0.5]);
    await page.keyboard.press('m');
    assert.equal((await state()).density, 0);
    await page.keyboard.press('m');
    await page.keyboard.press('o');
    assert.equal((await state()).mode, 'orbit');
    await page.keyboard.press('2');
    await page.waitForFunction(() => window.zonal.state.activeCamera === 1 && !window.zonal.flight);
    await page.keyboard.press('h');
    await page.locator('#exposure').focus();
    const before = await camera(page);
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('w');
    await page.waitForTimeout(100);
    assert.ok((await state()).stops > 0.5 && far((await camera(page)).eye, before.eye) < 1e-9);
    await page.keyboard.press('?');
    await page.locator('#canvas').focus();
    await page.keyboard.press('?');
    assert.ok(await page.locator('#help').isVisible());
    await page.keyboard.press('Escape');
    assert.ok(!(await page.locator('#help').isVisible()));
  });

  await t.test('a saved camera is that of zonal render', async () => {
    await page.evaluate(() => window.zonal.flyTo(1));
    await page.waitForFunction(() => !window.zonal.flight);
    if (!(await page.locator('#panel').isVisible())) await page.locator('#panelButton').click();
    const [saved] = await Promise.all([page.waitForEvent('download'), page.locator('#saveCamera').click()]);
    assert.equal(saved.suggestedFilename(), 'camera.toml');
    await saved.saveAs(file('camera.toml'));
    await page.locator('#copyCamera').click();
    await page.waitForFunction(() => !document.getElementById('copied').hidden);
    const options = (await page.locator('#copied').innerText()).replace('Copied: ', '').split(' ');
    // Both are the second camera of the scene, whose picture is wider than 4:3 or as wide.
    const small = ['--size', '16x12', '--samples', '4', '-o'];
    run('render', solution, '--camera-file', 'camera.toml', ...small, 'file.exr');
    run('render', solution, ...options, ...small, 'options.exr');
    run('render', solution, '--camera', 'aisle', ...small, 'scene.exr');
    const [a, b, c] = ['file.exr', 'options.exr', 'scene.exr'].map(floatsOf);
    assert.deepEqual(a, b);
    const [sum, off] = [0, 1].map((k) => a.reduce((s, x, i) => s + (k ? Math.abs(x - c[i]) : x), 0));
    assert.ok(off < 0.02 * sum, `${off} ${sum}`);
  });

  await t.test('false colours of direct light are chosen and kept in the address', async () => {
    await page.evaluate(() => window.zonal.set({ show: 'irradiance' }));
    await page.locator('#part').selectOption('direct');
    await page.waitForFunction(() => location.hash.includes('part=direct'), null, { timeout: 20000 });
    assert.match(await page.locator('#legend').innerText(), /Irradiance of direct light/);
    assert.ok((await spread(page)) > 10);
    await page.evaluate(() => window.zonal.set({ show: 'picture', part: 'total' }));
  });

  await t.test('every control is reached by Tab with a visible focus', async () => {
    const met = new Set();
    await page.locator('#canvas').focus();
    for (let i = 0; i < 30; i++) {
      await page.keyboard.press('Tab');
      const [id, seen] = await page.evaluate(() => {
        const a = document.activeElement;
        const box = a.matches('[type=radio]') ? a.nextElementSibling : a;
        return [a.id || a.value, getComputedStyle(box).outlineStyle !== 'none' || a === document.body];
      });
      assert.ok(seen, `${id} shows no focus`);
      met.add(id);
    }
    for (const id of ['camera', 'walk', 'orbit', 'helpButton', 'panelButton', 'exposure', 'density', 'light0', 'light1']) assert.ok(met.has(id), id);
    const unnamed = await page.evaluate(() => [...document.querySelectorAll('button, input, select')]
      .filter((e) => !(e.getAttribute('aria-label') || e.textContent.trim() || e.labels?.length)).map((e) => e.id));
    assert.deepEqual(unnamed, []);
  });

  await t.test('URL restores the view', async () => {
    await page.evaluate(() => window.zonal.set({ stops: 1, density: 0.5, factors: [0.5, 1] }));
    await page.waitForFunction(() => location.hash.includes('density'), null, { timeout: 20000 });
    const before = await camera(page);
    const again = (await open(browser, page.url(), { width: 120, height: 90 })).page;
    const state = await again.evaluate(() => window.zonal.state);
    assert.ok(far(state.camera.eye, before.eye) < 1e-4 && far(state.camera.forward, before.forward) < 1e-4);
    assert.deepEqual([state.stops, state.density, state.factors], [1, 0.5, [0.5, 1]]);
    await again.context().close();
  });

  await t.test('all controls fit in a narrow window', async () => {
    const phone = await open(browser, server.url, { width: 320, height: 568, hasTouch: true, isMobile: true, reducedMotion: 'reduce' });
    const p = phone.page;
    assert.deepEqual(complaints(phone.said), []);
    assert.ok((await spread(p)) > 15);
    const fits = async (selector) => {
      const box = await p.locator(selector).boundingBox();
      assert.ok(box && box.x >= 0 && box.y >= 0 && box.x + box.width <= 320 && box.y + box.height <= 568.5, `${selector} ${JSON.stringify(box)}`);
    };
    assert.equal(await p.evaluate(() => document.documentElement.scrollWidth), 320);
    for (const s of ['#camera', '#walk', '#orbit', '#helpButton', '#panelButton']) await fits(s);
    await p.tap('#panelButton');
    await fits('#panel');
    assert.ok((await p.locator('#light1').count()) === 1);
    await p.tap('#panelButton');
    await p.touchscreen.tap(160, 400);
    await fits('#probe');
    await p.tap('#probe button');
    await p.evaluate(() => window.zonal.set({ show: 'radiosity' }));
    await p.waitForFunction(() => !document.getElementById('legend').hidden);
    await fits('#legend');
    // One finger looks, two move; with reduced motion cameras change without a flight.
    const session = await p.context().newCDPSession(p);
    const touch = (type, points) => session.send('Input.dispatchTouchEvent', { type, touchPoints: points.map(([x, y], id) => ({ x, y, id })) });
    const a = await camera(p);
    await touch('touchStart', [[160, 300]]);
    await touch('touchMove', [[200, 300]]);
    await touch('touchMove', [[240, 310]]);
    await touch('touchEnd', []);
    const b = await camera(p);
    assert.ok(far(a.forward, b.forward) > 0.05 && far(a.eye, b.eye) < 1e-9);
    await touch('touchStart', [[120, 300], [200, 300]]);
    await touch('touchMove', [[110, 300], [210, 300]]);
    await touch('touchMove', [[90, 300], [230, 300]]);
    await touch('touchEnd', []);
    const c = await camera(p);
    assert.ok(far(b.eye, c.eye) > 0.05);
    await p.evaluate(() => window.zonal.flyTo(1));
    assert.equal(await p.evaluate(() => window.zonal.flight), null);
    await p.context().close();
  });

  await t.test('server ends cleanly on an interrupt', async () => {
    assert.equal(await server.stop(), 0);
  });

  await t.test('a scene is solved while its page is open, and again after a change', async () => {
    const room = (reflectance) => `[solve]\npatch_size = 0.25\n[[surface]]\nname = "room"\nroom = { min = [0,0,0], max = [1,1,1] }\nreflectance = ${reflectance}\nfaces.z1 = { emission = 3 }\n[[camera]]\nname = "door"\norigin = [0.2,0.1,0.5]\ntarget = [0.6,0.9,0.4]\n`;
    writeFileSync(file('room.toml'), room(0.3));
    const live = await serve('room.toml');
    const { page: p, said } = await open(browser, live.url);
    await p.evaluate(() => window.zonal.set({ stops: 1.5 }));
    const solved = (patches) => p.waitForFunction((n) => window.zonal?.data.counts.patches === n && document.getElementById('solving').hidden, patches, { timeout: 60000 });
    // The draft has patches of twice the size.
    await solved(96);
    const before = await spread(p);
    assert.equal(await p.evaluate(() => window.zonal.state.stops), 1.5);
    assert.ok(before > 10, `${before}`);
    // Direct light first, its error unknown; then the exchange with stated errors, that of light within patches of 0.25 m included.
    const series = await p.evaluate(() => window.zonal.data.report.estimates.map((e) => e.patches[0]));
    assert.equal(series[0], null);
    assert.ok(series.length === 3 && series.slice(1).every((e) => e >= 0 && e < 0.03), `${series}`);
    assert.match(await p.evaluate(() => document.getElementById('report').textContent), /RMS error of Hunknown → [\d.<]+.* → [\d.<]+/);
    const notes = await p.evaluate(() => window.zonal.data.report.notes);
    assert.ok(notes.every((n) => !/being computed/.test(`${n.text} ${n.advice}`)), JSON.stringify(notes));
    writeFileSync(file('room.toml'), room(0.9).replace('0.25', '0.2'));
    await solved(150);
    assert.equal(await p.evaluate(() => window.zonal.state.stops), 1.5);
    writeFileSync(file('room.toml'), 'nonsense');
    await p.waitForFunction(() => /Not solved/.test(document.getElementById('solving').textContent), null, { timeout: 20000 });
    assert.deepEqual(complaints(said), []);
    assert.equal(await live.stop(), 0);
    await p.context().close();
  });

  await t.test('single-file page opens without a server', async () => {
    run('export', solution, '-o', 'page.html');
    t.diagnostic(`page.html: ${readFileSync(file('page.html')).length} bytes`);
    const alone = await open(browser, pathToFileURL(file('page.html')).href);
    assert.deepEqual(complaints(alone.said), []);
    assert.deepEqual(alone.asked.filter((u) => !/^(file|blob|data):/.test(u)), []);
    assert.equal(alone.asked.filter((u) => u.startsWith('file:')).length, 1);
    assert.ok((await spread(alone.page)) > 20);
    await alone.page.context().close();
  });

  await t.test('damaged data and missing WebGL 2 are reported', async () => {
    const text = readFileSync(file('page.html'), 'utf8');
    const at = text.indexOf('type="text/plain">') + 5000;
    const told = async (name, content, before) => {
      writeFileSync(file(name), content);
      const { page: p } = await open(browser, pathToFileURL(file(name)).href, { loaded: false, before });
      const words = await p.locator('#cover').innerText();
      await p.context().close();
      return words;
    };
    const flipped = text.slice(0, at) + (text[at] === 'A' ? 'B' : 'A') + text.slice(at + 1);
    assert.match(await told('flipped.html', flipped), /damaged/);
    assert.match(await told('cut.html', text.slice(0, at) + text.slice(at + 4000)), /damaged/);
    assert.match(await told('plain.html', text, () => {
      HTMLCanvasElement.prototype.getContext = () => null;
    }), /WebGL 2/);
  });

  await browser.close();
});
