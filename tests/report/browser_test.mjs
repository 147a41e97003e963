// Opens the page of a small study in headless Chromium: reads, sorts, filters, clicks, scrubs, and looks for anything that the
// page asks of the network or that a hostile name has done. ASLIO_SCREENSHOTS=FOLDER keeps pictures.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdirSync, mkdtempSync, rmSync, statSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {pathToFileURL} from 'node:url';

import {channelOf} from '../../tools/report/src/decode.js';
import {significant, strengthOf} from '../../tools/report/src/model.js';
import {valueAt} from '../../tools/report/src/value_at.js';

const {ASLIO_PROGRAM, ASLIO_FIXTURE, ASLIO_CHROMIUM, ASLIO_MODULES, ASLIO_SCREENSHOTS} = process.env;
const puppeteer = createRequire(join(ASLIO_MODULES, 'package.json'))('puppeteer-core');
const folder = mkdtempSync(join(tmpdir(), 'aslio_report_'));
const complaints = [], requests = [];
let browser, page;

before(async () => {
  execFileSync(ASLIO_FIXTURE, [folder]);
  execFileSync(ASLIO_PROGRAM, ['report', folder, '--quiet']);
  browser = await puppeteer.launch({
    executablePath: ASLIO_CHROMIUM, headless: true, timeout: 120_000, protocolTimeout: 240_000,
    args: ['--no-sandbox', '--enable-unsafe-swiftshader', '--use-gl=angle', '--use-angle=swiftshader', '--disable-dev-shm-usage'],
  });
  page = await browser.newPage();
  await page.setViewport({width: 1400, height: 900});
  page.on('console', (message) => ['error', 'warn'].includes(message.type()) && complaints.push(message.text()));
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('request', (request) => requests.push(request.url()));
  await page.evaluateOnNewDocument(() => { globalThis.fail = () => { globalThis.hacked = true; }; });
  // A machine that is busy with other tests takes its time to draw in software.
  page.setDefaultTimeout(300_000);
  await page.goto(pathToFileURL(join(folder, 'report.html')).href, {waitUntil: 'domcontentloaded', timeout: 300_000});
  await page.waitForSelector('html[data-ready="true"]');
  await look('runs');
  await page.waitForSelector('.timeline .u-over');
});

after(async () => {
  await browser?.close();
  rmSync(folder, {recursive: true, force: true});
});

/** Sections draw what is near the view. */
const look = (id) => page.$eval(`#${id}`, (element) => element.scrollIntoView());
const texts = (selector) => page.$$eval(selector, (elements) => elements.map((element) => element.textContent));
const shot = async (name) => ASLIO_SCREENSHOTS && page.screenshot({path: join(ASLIO_SCREENSHOTS, `${name}.png`), fullPage: true});

test('a channel holds no value where its line breaks', () => {
  // 0 s, 1 s, 3 s and 4 s with the values 5, 6, 7 and 8, the third after a break.
  const packed = (...differences) => {
    const bytes = [];
    for (const difference of differences) {
      let left = 2 * difference;
      for (; left > 127; left >>= 7) bytes.push((left & 127) | 128);
      bytes.push(left);
    }
    return btoa(String.fromCharCode(...bytes));
  };
  const channel = {t: packed(0, 10000, 20000, 10000), v: packed(5, 1, 1, 1), unit: 1, breaks: packed(2)};
  assert.deepEqual(channelOf(channel), {t: Float64Array.of(0, 1, 2, 3, 4), v: Float64Array.of(5, 6, NaN, 7, 8), unit: 1});
  delete channel.breaks;
  assert.deepEqual(channelOf(channel), {t: Float64Array.of(0, 1, 3, 4), v: Float64Array.of(5, 6, 7, 8), unit: 1});
});

test('the study stands on top, with its verdict', async () => {
  const text = await page.$eval('#study', (element) => element.textContent);
  for (const words of ['fixture', 'Which is better?', 'Lower median.', '11 of 12', 'a and b do not differ']) assert.ok(text.includes(words), words);
  assert.deepEqual(await texts('.claims .badge'), ['does not hold', 'not decided', 'holds', 'not decided']);
  assert.ok(text.includes('(1 run is missing)'));
});

test('the table shows medians, marks and ranks', async () => {
  assert.deepEqual(await texts('.results tbody th'), ['loop', 'turn']);
  const cells = await texts('.results tbody tr:first-child .value');
  assert.deepEqual(cells, ['55.0', '25.0', '-']);
  assert.equal(await page.$eval('.results tbody tr:first-child td:nth-child(3) .value', (e) => getComputedStyle(e).fontWeight), '750');
  assert.deepEqual(await texts('.results tbody tr:nth-child(2) .value'), ['55.0', '95.0', 'x']);
});

test('methods stand by their labels, ranks in words, and only what is significant has a colour', async () => {
  assert.match((await texts('.results thead th'))[1], /10 Hz, fixed/);
  const standing = await texts('.standing tbody tr');
  assert.ok(standing.some((text) => text.includes('best on 1, second on 1') || text.includes('best on 1')), String(standing));
  assert.match((await texts('.standing thead th'))[1], /^Rank over 2 sequences$/);
  // p (Holm) is 0.125 there.
  assert.equal((await page.$$('.standing .better, .standing .worse')).length, 0);
  assert.ok(significant({more: [['p (Holm)', '< 0.001']]}) && significant({more: [['p (Holm)', '0.049']]}));
  assert.ok(!significant({more: [['p', '0.001'], ['p (Holm)', '']]}) && !significant({more: []}));
  assert.ok(strengthOf(1.06) < 0.1 && strengthOf(0.25) === 1);
});

test('the LaTeX is copied by a button', async () => {
  await page.evaluate(() => [...document.querySelectorAll('#results button')].find((button) => button.textContent === 'LaTeX').click());
  assert.match(await page.$eval('dialog textarea', (area) => area.value), /\\label\{tab:fixture:ate_m\}/);
  await page.click('dialog .copy');
  await page.waitForFunction(() => document.querySelector('dialog output').value !== '');
  await page.evaluate(() => document.querySelector('dialog form button:not(.copy)').click());
  await page.waitForFunction(() => !document.querySelector('dialog'));
});

test('a click on a head sorts, by keyboard too', async () => {
  await page.click('button[data-sort="1"]');
  assert.deepEqual(await texts('.results tbody th'), ['loop', 'turn']);
  await page.focus('button[data-sort="1"]');
  await page.keyboard.press('Enter');
  assert.deepEqual(await texts('.results tbody th'), ['turn', 'loop']);
  assert.equal(await page.$eval('button[data-sort="1"]', (e) => e.closest('th').getAttribute('aria-sort')), 'descending');
});

test('filters leave what they name', async () => {
  await page.type('input[type="search"]', 'loo');
  assert.deepEqual(await texts('.results tbody th'), ['loop']);
  await page.click('input[type="search"]', {clickCount: 3});
  await page.keyboard.press('Backspace');
  await page.click('#results .chip:nth-child(1)');
  assert.equal((await texts('.results thead th')).length, 3);
  await page.click('#results .chip:nth-child(1)');
  assert.equal((await texts('.results thead th')).length, 4);
});

test('a cell opens its runs, and a run is looked at', async () => {
  await page.click('.results tbody tr:last-child button[data-cell="1"]');
  const runs = await texts('.runs tbody th');
  assert.deepEqual(runs, ['loop_1', 'loop_2']);
  await page.click('.runs tbody tr:nth-child(2) button');
  assert.equal(await page.$eval('select[aria-label="recording"]', (e) => e.value), 'loop_2');
  assert.match(await page.$eval('tr.focus th', (e) => e.textContent), /as_lio_plus/);
});

test('time is scrubbed in space and in all charts at once', async () => {
  const canvas = () => page.$eval('.space canvas', (e) => e.toDataURL().length > 2000 && e.toDataURL());
  const early = async (time) => {
    await page.$eval('.scrub', (slider, t) => {
      slider.value = t;
      slider.dispatchEvent(new Event('input', {bubbles: true}));
    }, time);
    await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
    return canvas();
  };
  const a = await early(10), b = await early(40);
  assert.ok(a && b && a !== b, 'the view in space has not changed');
  assert.match(await page.$eval('.clock', (e) => e.textContent), /^40\.0 of 60\.0 s$/);
  const left = await page.$$eval('.now', (lines) => lines.map((line) => Math.round(parseFloat(line.style.left))));
  assert.ok(left.length >= 8 && left.every((x) => x === 67), String(left));
  await page.focus('.space');
  await page.keyboard.press('ArrowLeft');
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  assert.notEqual(await canvas(), b, 'arrow keys do not turn the view');
});

test('the value of a line is that at the time asked for', () => {
  const line = {t: [0, 1, 3], v: [10, 20, 40]};
  assert.equal(valueAt(line, 2, false, false), 30);
  assert.equal(valueAt(line, 2, true, false), 40);
  assert.ok(Math.abs(valueAt({t: [0, 2], v: [1, 100]}, 1, false, true) - 10) < 1e-9);
  assert.ok(Number.isNaN(valueAt(line, 3.5, false, false)) && Number.isNaN(valueAt({t: [0, 1, 2], v: [1, NaN, 3]}, 1.5, false, false)));
});

test('dots and readings are all at the time of the cursor', async () => {
  const box = await (await page.$('.timeline .u-over')).boundingBox();
  await page.mouse.move(box.x + 0.4137 * box.width, box.y + 30);
  await page.waitForFunction(() => document.querySelectorAll('.timeline .dot:not([hidden])').length > 8);
  const left = new Set(await page.$$eval('.timeline .dot:not([hidden])', (dots) => dots.map((dot) => Math.round(parseFloat(dot.style.left)))));
  assert.equal(left.size, 1);
  assert.equal(new Set(await texts('.readings .unit')).size, 1);
});

test('a lane under the charts shows when a run was weak, raised an alarm or was lost', async () => {
  const titles = await page.$$eval('.lane .bar i', (marks) => marks.map((mark) => mark.title));
  assert.ok(titles.some((title) => /the monitor raised its alarm$/.test(title)) && titles.some((title) => /left a direction open$/.test(title)));
  const [bar, over] = await Promise.all(['.lane .bar', '.timeline .u-over'].map(async (at) => (await page.$(at)).boundingBox()));
  assert.ok(Math.abs(bar.x - over.x) < 1 && Math.abs(bar.width - over.width) < 1, `under the drawing area: ${JSON.stringify([bar, over])}`);
  const widths = await page.$$eval('.lane .bar i.lost:not([hidden])', (marks) => marks.map((mark) => mark.getBoundingClientRect().width));
  assert.ok(widths.length > 0 && widths.every((width) => width >= 2.9), 'an alarm of one update can be seen');
});

test('a zoom of one chart is that of all', async () => {
  const box = await (await page.$('.timeline .u-over')).boundingBox();
  await page.mouse.move(box.x + 0.25 * box.width, box.y + 30);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.5 * box.width, box.y + 30, {steps: 4});
  await page.mouse.up();
  await page.waitForFunction(() => document.querySelector('.now').hidden);
  const hidden = await page.$$eval('.now', (lines) => lines.map((line) => line.hidden));
  assert.ok(hidden.every(Boolean), 't = 40 s lies outside 15 to 30 s');
  await page.mouse.click(box.x + 10, box.y + 30, {clickCount: 2});
  await page.waitForFunction(() => !document.querySelector('.now').hidden);
});

test('another recording is another course, with its own time', async () => {
  await page.select('select[aria-label="recording"]', 'turn_1');
  assert.match(await page.$eval('.clock', (e) => e.textContent), /^45\.0 of 45\.0 s$/);
  assert.ok((await texts('#runs tbody td')).includes('90.0'), 'the figures of as_lio_plus on turn_1');
  await page.select('select[aria-label="recording"]', 'loop_1');
  assert.match(await page.$eval('.clock', (e) => e.textContent), /^60\.0 of 60\.0 s$/);
});

test('charts, configurations and manifest are there', async () => {
  await look('charts');
  await page.waitForFunction(() => document.querySelectorAll('#charts .chart svg').length === 3);
  assert.ok((await page.$$('#charts .chart svg path')).length > 20);
  const keys = await texts('#configs tbody th');
  assert.ok(keys.includes('window.type') && keys.includes('window.seg_step') && !keys.includes('map.type'), String(keys));
  assert.ok((await texts('#manifest tbody th')).includes('build.flags'));
  assert.ok((await texts('#manifest tbody td')).includes('IMU delay 2.03 ms'));
  assert.ok((await texts('#failures td')).some((text) => text.includes('off by 9 m, </script>')));
});

test('names in cost against accuracy do not cover each other', async () => {
  const names = await texts('.chip');
  const overlaps = await page.$$eval('#charts .chart', (charts, all) => {
    const boxes = [...charts.at(-1).querySelectorAll('text')].filter((text) => all.includes(text.textContent)).map((text) => text.getBoundingClientRect());
    return [boxes.length, boxes.filter((a, i) => boxes.some((b, k) => k > i && a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom)).length];
  }, names);
  assert.ok(overlaps[0] >= 2 && overlaps[1] === 0, String(overlaps));
});

test('no table is cut on paper', async () => {
  await page.evaluate(() => dispatchEvent(new Event('beforeprint')));
  const wide = await page.$$eval('table', (tables) => tables.filter((table) => table.offsetParent && table.getBoundingClientRect().right > 702 + document.querySelector('main').getBoundingClientRect().left)
    .map((table) => `${table.className} ${table.getBoundingClientRect().width}`));
  await page.evaluate(() => dispatchEvent(new Event('afterprint')));
  assert.deepEqual(wide, []);
});

test('light and dark, and narrow', async () => {
  const background = () => page.$eval('body', (e) => getComputedStyle(e).backgroundColor);
  await page.evaluate(() => scrollTo(0, 0));
  const light = await background();
  await shot('light');
  await page.click('.theme');
  assert.notEqual(await background(), light);
  await shot('dark');
  await page.setViewport({width: 420, height: 900});
  await page.waitForFunction(() => document.documentElement.scrollWidth <= 420);
  await look('results');
  await page.waitForFunction(() => [...document.querySelectorAll('#results .scroll')].every((place) => place.classList.contains('more-right') === (place.scrollWidth - place.clientWidth - place.scrollLeft > 2)));
  assert.ok((await page.$$('#results .scroll.more-right')).length > 0, 'a table that is cut fades out');
  await shot('narrow');
});

test('nothing was asked of the network, no error, no name became markup', async () => {
  assert.deepEqual(requests.filter((url) => !/^(file|data|blob):/.test(url)), []);
  assert.equal(requests.filter((url) => url.startsWith('file:')).length, 1);
  assert.deepEqual(complaints, []);
  assert.equal(await page.evaluate(() => globalThis.hacked), undefined);
  assert.equal((await page.$$('img')).length, 0);
  const names = await texts('.results thead th');
  assert.ok(names.some((name) => name.includes('<img src=x onerror=fail()>&"\'')), String(names));
});

test('the policy stops what is not part of the page', async () => {
  const outcome = await page.evaluate(() => new Promise((done) => {
    addEventListener('securitypolicyviolation', (event) => done(event.violatedDirective));
    const script = document.createElement('script');
    try { script.textContent = 'globalThis.hacked = true'; document.head.append(script); } catch { done('trusted types'); }
    setTimeout(() => done('nothing'), 500);
  }));
  assert.notEqual(outcome, 'nothing');
  assert.equal(await page.evaluate(() => globalThis.hacked), undefined);
});

test('the folder of an older study says what completes it', async () => {
  const older = join(folder, 'older');
  mkdirSync(older);
  execFileSync(ASLIO_FIXTURE, [older]);
  rmSync(join(older, 'study.json'));
  execFileSync(ASLIO_PROGRAM, ['report', older, '--quiet']);
  const other = await browser.newPage();
  other.setDefaultTimeout(300_000);
  await other.goto(pathToFileURL(join(older, 'report.html')).href, {waitUntil: 'domcontentloaded'});
  await other.waitForSelector('html[data-ready="true"]');
  const warnings = await other.$$eval('.card.warning', (cards) => cards.map((card) => card.textContent));
  const questions = await other.$$eval('.card.question', (cards) => cards.length);
  await other.close();
  assert.ok(warnings.some((text) => text.startsWith('Incomplete') && text.includes('study.json is missing')), String(warnings));
  assert.equal(questions, 0);
});

test('twenty runs of 500 m are there in three seconds, and below 30 MB', async () => {
  const large = join(folder, 'large'), file = join(large, 'report.html');
  mkdirSync(large);
  execFileSync(ASLIO_FIXTURE, [large, 'long']);
  execFileSync(ASLIO_PROGRAM, ['report', large, '--quiet']);
  const megabytes = statSync(file).size / 1e6;
  const seconds = [];
  const other = await browser.newPage();
  other.setDefaultTimeout(300_000);
  // What else the machine does adds to it, and takes nothing away.
  for (let i = 0; i < 5 && !(seconds.at(-1) < 3); ++i) {
    const begin = performance.now();
    await other.goto(pathToFileURL(file).href, {waitUntil: 'domcontentloaded'});
    await other.waitForSelector('html[data-ready="true"]');
    seconds.push((performance.now() - begin) / 1000);
  }
  const runs = await other.$$eval('.results tbody .value', (cells) => cells.length);
  await other.close();
  assert.equal(runs, 10);
  assert.ok(megabytes < 30, `${megabytes} MB`);
  assert.ok(Math.min(...seconds) < 3, `${seconds} s`);
  if (ASLIO_SCREENSHOTS) console.log(`${megabytes.toFixed(1)} MB, ready after ${seconds.map((s) => s.toFixed(2))} s`);
});
