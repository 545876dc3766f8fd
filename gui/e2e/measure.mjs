// SPDX-License-Identifier: Apache-2.0
// Measures what docs/performance.md says of the browser GUI, and prints its table:
//
//     node e2e/measure.mjs PARTS PROGRAMS GUI MPIEXEC...
//
// PARTS: those of e2e/measure whose file names contain one of these words, which commas separate; "measure" is all. The other words
// are those of run.mjs. Times of a machine that does other things are upper bounds: each row has the load when it was measured.
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { startVitest } from 'vitest/node';

const [parts, programs, gui, ...mpiexec] = process.argv.slice(2);
if (mpiexec.length === 0) throw new Error('expected PARTS PROGRAMS GUI MPIEXEC...');
const folder = mkdtempSync(join(tmpdir(), 'galaxy-measure-'));
const results = join(folder, 'rows');
writeFileSync(results, '');
const vitest = await startVitest('test', parts.split(','), {
  config: fileURLToPath(new URL('vitest.config.ts', import.meta.url)),
  include: ['measure/*.measure.ts'],
  testTimeout: 400_000,
  watch: false,
  provide: { programs, gui, pictures: folder, mpiexec, results },
});
await vitest.close();
const rows = readFileSync(results, 'utf8');
process.stdout.write(`\n| what | goal | found | load |\n|---|---|---|---|\n${rows}`);
rmSync(folder, { recursive: true });
