// Two simulated robots drive, a browser without a screen looks on and uses every control.
// Usage: node run.mjs --bin build/release/bin [--chromium /usr/bin/chromium] [--shots FOLDER]
// Ends with 0 if all went well, 77 (skipped) where there is no Chromium.
import {existsSync} from 'node:fs';
import {mkdir} from 'node:fs/promises';
import {parseArgs} from 'node:util';
import {Page} from './page.mjs';
import {Server} from './server.mjs';
import {steps} from './steps.mjs';

const {values: options} = parseArgs({options: {
  bin: {type: 'string'}, chromium: {type: 'string', default: '/usr/bin/chromium'},
  shots: {type: 'string', default: ''},
}});
if (!existsSync(options.chromium)) {
  console.log(`no Chromium at ${options.chromium}: apt-get install chromium`);
  process.exit(77);
}
if (options.shots) await mkdir(options.shots, {recursive: true});

const server = await Server.make(options.bin);
let page;
try {
  await server.start();
  page = await Page.open(options.chromium, options.shots);
  for (const [name, step] of steps) {
    const began = Date.now();
    try {
      await step(page, server);
      if (page.problems.length > 0) throw new Error(`the page says: ${page.problems.join('\n')}`);
    } catch (error) {
      await page.shot('failed').catch(() => undefined);
      console.log(`FAILED: ${name}\n${error.stack}`);
      process.exitCode = 1;
      break;
    }
    console.log(`ok  ${name} (${((Date.now() - began) / 1000).toFixed(1)} s)`);
  }
} finally {
  await page?.close();
  await server.remove();
}
