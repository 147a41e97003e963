// Bundles src/ into report.js and report.css.
//   node build.mjs OUTPUT_FOLDER [MODULES_FOLDER]
import {build} from 'esbuild';
import {mkdir} from 'node:fs/promises';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const output = process.argv[2] ?? join(here, 'dist');
await mkdir(output, {recursive: true});
await build({
  entryPoints: {report: join(here, 'src/main.js')},
  outdir: output,
  bundle: true,
  minify: true,
  charset: 'ascii',
  format: 'iife',
  target: ['es2021', 'chrome100', 'firefox100', 'safari15'],
  define: {'process.env.NODE_ENV': '"production"'},
  legalComments: 'eof',
  logLevel: 'warning',
});
