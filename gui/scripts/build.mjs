// SPDX-License-Identifier: Apache-2.0
// Makes the page's files, as CMake does:
//
//     node scripts/build.mjs FOLDER [--if-possible]
//
// Installs the packages of package-lock.json into node_modules unless they are there, checks and bundles the sources, and leaves in
// FOLDER: index.html, assets/, LICENSES.txt of all packages of which something is in the bundle, and FILE.gz beside each text file.
// With --if-possible it says so where npm cannot get the packages, and takes a ready dist/ if there is one.
import { execFileSync } from 'node:child_process';
import {
  cpSync,
  existsSync,
  readdirSync,
  readFileSync,
  renameSync,
  rmSync,
  statSync,
  writeFileSync,
} from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { licenses } from './licenses.mjs';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const folder = resolve(process.argv[2] ?? 'dist');
const ifPossible = process.argv.includes('--if-possible');
const making = `${folder}.making`;

const run = (program, ...words) => execFileSync(program, words, { cwd: root, stdio: 'inherit' });
const local = (name, ...words) => run(process.execPath, join(root, 'node_modules', name), ...words);

// npm writes this file last.
function installed() {
  const mark = join(root, 'node_modules/.package-lock.json');
  return existsSync(mark) && statSync(mark).mtimeMs >= statSync(join(root, 'package-lock.json')).mtimeMs;
}

function compress(at) {
  for (const entry of readdirSync(at, { withFileTypes: true })) {
    const path = join(at, entry.name);
    if (entry.isDirectory()) compress(path);
    else if (/\.(html|js|css|svg|json|txt)$/.test(entry.name))
      writeFileSync(`${path}.gz`, gzipSync(readFileSync(path), { level: 9 }));
  }
}

function install() {
  try {
    run('npm', 'ci', '--ignore-scripts', '--no-progress');
  } catch (error) {
    process.stderr.write(
      'npm cannot get the packages. cmake -DGALAXY_GUI=OFF builds Galaxy without its browser GUI.\n',
    );
    if (!ifPossible) throw error;
    rmSync(join(root, 'node_modules'), { recursive: true, force: true });
    const ready = join(root, 'dist');
    if (existsSync(join(ready, 'index.html'))) cpSync(ready, folder, { recursive: true });
    process.exit(0);
  }
}

if (!installed()) install();
local('typescript/bin/tsc');
local('vite/bin/vite.js', 'build', '--outDir', making, '--emptyOutDir', '--logLevel', 'warn');
writeFileSync(join(making, 'LICENSES.txt'), licenses(root));
compress(making);
rmSync(folder, { recursive: true, force: true });
renameSync(making, folder);
