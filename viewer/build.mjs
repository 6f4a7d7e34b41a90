// Builds the page into crates/app/viewer, from where cargo embeds it; --check verifies that the built files are up to date.

import { build } from 'esbuild';
import { readFileSync, mkdirSync, writeFileSync, existsSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { join } from 'node:path';

const here = fileURLToPath(new URL('.', import.meta.url));
const out = join(here, '../crates/app/viewer');
const common = { bundle: true, minify: true, write: false, target: ['es2022', 'chrome105', 'firefox115', 'safari16.4'], legalComments: 'none', charset: 'utf8' };

const one = async (entry, more) => (await build({ ...common, entryPoints: [join(here, 'src', entry)], ...more })).outputFiles[0].text;
const files = {
  // Shaders keep their line breaks, on which the preprocessor depends, but not their indentation.
  'viewer.js': (await one('main.js', { format: 'iife' })).replace(/\n[ \t]+/g, '\n'),
  'viewer.css': await one('style.css', {}),
  'index.html': readFileSync(join(here, 'src/index.html'), 'utf8'),
};
if (/<\/script|<!--/i.test(files['viewer.js']) || /<\/style/i.test(files['viewer.css'])) throw new Error('the bundle contains text that cannot be embedded in a page');

let stale = [];
mkdirSync(out, { recursive: true });
for (const [name, text] of Object.entries(files)) {
  const path = join(out, name);
  if (process.argv.includes('--check')) {
    if (!existsSync(path) || readFileSync(path, 'utf8') !== text) stale.push(name);
  } else {
    writeFileSync(path, text);
    console.log(`${name}: ${text.length} characters`);
  }
}
if (stale.length) {
  console.error(`${stale.join(', ')}: out of date; run npm run build in viewer/`);
  process.exit(1);
}
