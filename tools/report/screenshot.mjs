// A picture of a report, or its print as PDF, by headless Chromium.
//
//   node screenshot.mjs --page out/report.html --output figure.png [--section runs] [--errors 50] [--width 1400] [--height 900] [--dark]
//
// --errors draws the errors of trajectories so many times as large (1, 10, 50, 200). The ending of --output decides: png, webp or pdf. Needs puppeteer-core, from the folder ASLIO_MODULES where the page is built, and
// Chromium (ASLIO_CHROMIUM, default /usr/bin/chromium).
import {createRequire} from 'node:module';
import {extname, join, resolve} from 'node:path';
import {pathToFileURL} from 'node:url';
import {parseArgs} from 'node:util';

const {values: options} = parseArgs({options: {
  page: {type: 'string'}, output: {type: 'string'}, section: {type: 'string'}, errors: {type: 'string', default: '1'}, dark: {type: 'boolean', default: false},
  width: {type: 'string', default: '1400'}, height: {type: 'string', default: '900'},
}});
const modules = process.env.ASLIO_MODULES ?? 'build/release/tools/report/page';
const puppeteer = createRequire(join(resolve(modules), 'package.json'))('puppeteer-core');
const kind = extname(options.output).slice(1);

const browser = await puppeteer.launch({
  executablePath: process.env.ASLIO_CHROMIUM ?? '/usr/bin/chromium', headless: true, timeout: 120_000, protocolTimeout: 240_000,
  args: ['--no-sandbox', '--enable-unsafe-swiftshader', '--use-gl=angle', '--use-angle=swiftshader', '--disable-dev-shm-usage'],
});
try {
  const page = await browser.newPage();
  page.setDefaultTimeout(120_000);
  await page.setViewport({width: Number(options.width), height: Number(options.height)});
  await page.emulateMediaFeatures([{name: 'prefers-color-scheme', value: options.dark ? 'dark' : 'light'}]);
  await page.goto(pathToFileURL(resolve(options.page)).href, {waitUntil: 'domcontentloaded', timeout: 120_000});
  await page.waitForSelector('html[data-ready="true"]');
  // Sections draw what is near the view: all of them have been there once.
  for (const section of await page.$$('section')) {
    await section.scrollIntoView();
    await new Promise((done) => setTimeout(done, 400));
  }
  await page.select('select[aria-label="error drawn"]', options.errors);
  await page.$eval(options.section ? `#${options.section}` : 'body', (element) => element.scrollIntoView());
  await new Promise((done) => setTimeout(done, 2500));
  if (kind === 'pdf') await page.pdf({path: options.output, format: 'A4', printBackground: true});
  else await page.screenshot({path: options.output, type: kind, ...(kind === 'webp' ? {quality: 80} : {})});
} finally {
  await browser.close();
}
