// SPDX-License-Identifier: Apache-2.0
// Runs the tests of the page in a real browser against a real server:
//
//     node e2e/run.mjs FILES PROGRAMS GUI PICTURES MPIEXEC...
//
// FILES: those tests whose file names contain one of these words, which commas separate. PROGRAMS: the folder of gxyserver, gxyrender, gxydata and msdata. GUI: the built page. PICTURES: where pictures of the page are
// left. MPIEXEC: the command that starts ranks, in words. The environment may have GALAXY_SEED, the seed of what is chosen by chance
// (default 1), GALAXY_EDITS, how many edits each client of together.test.ts makes (default 60), GALAXY_PYTHON, a Python with NumPy,
// and GALAXY_SOAK, the minutes of soak.test.ts, which is left out without it. Exit status 77: there is no /usr/bin/chromium, so nothing was tested.
import { existsSync, mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { startVitest } from 'vitest/node';

const [files, programs, gui, pictures, ...mpiexec] = process.argv.slice(2);
if (!existsSync('/usr/bin/chromium')) {
  process.stdout.write('There is no /usr/bin/chromium: the page is not tested.\n');
  process.exit(77);
}
if (mpiexec.length === 0) throw new Error('expected FILES PROGRAMS GUI PICTURES MPIEXEC...');
mkdirSync(pictures, { recursive: true });
const config = fileURLToPath(new URL('vitest.config.ts', import.meta.url));
const vitest = await startVitest('test', files.split(','), {
  config,
  watch: false,
  provide: {
    ...{ programs, gui, pictures, mpiexec },
    seed: Number(process.env['GALAXY_SEED'] ?? 1),
    python: process.env['GALAXY_PYTHON'] ?? '/usr/bin/python3',
    soak: Number(process.env['GALAXY_SOAK'] ?? 0),
    edits: Number(process.env['GALAXY_EDITS'] ?? 60),
  },
});
await vitest.close();
