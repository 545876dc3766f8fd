// SPDX-License-Identifier: Apache-2.0
// Runs a script by Node if the packages of package-lock.json are in node_modules, as the build leaves them:
//
//     node scripts/tool.mjs SCRIPT [ARGUMENTS...]
//
// SCRIPT is below gui/. Exit status 77: the packages are not there, as where npm cannot reach its registry, so nothing was run.
import { spawnSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = join(dirname(fileURLToPath(import.meta.url)), '..');
const [script, ...words] = process.argv.slice(2);
if (!existsSync(join(root, 'node_modules/.package-lock.json'))) {
  process.stdout.write(`There are no packages in ${root}/node_modules: ${script} is not run.\n`);
  process.exit(77);
}
const { status, error } = spawnSync(process.execPath, [join(root, script), ...words], {
  cwd: root,
  stdio: 'inherit',
});
if (error) throw error;
process.exit(status ?? 1);
