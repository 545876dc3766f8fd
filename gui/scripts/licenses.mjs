// SPDX-License-Identifier: Apache-2.0
import { readdirSync, readFileSync } from 'node:fs';
import { join } from 'node:path';

/**
 * The licences of the packages that package-lock.json has for the page itself, not for building and testing it, with their texts.
 * Throws an Error if a package has none.
 */
export function licenses(root) {
  const lock = JSON.parse(readFileSync(join(root, 'package-lock.json'), 'utf8'));
  const parts = ['The page of Galaxy has parts of these packages.\n'];
  for (const [path, { version, dev, license }] of Object.entries(lock.packages)) {
    if (path === '' || dev || path.includes('node_modules/@types/')) continue;
    const name = path.replace(/^.*node_modules\//, '');
    if (!license) throw new Error(`${name}: package-lock.json says no licence`);
    const folder = join(root, path);
    const file = readdirSync(folder).find((entry) => /^(licen[cs]e|copying)/i.test(entry));
    const text = file ? readFileSync(join(folder, file), 'utf8').trim() : `Licence: ${license}`;
    parts.push(`${'-'.repeat(100)}\n${name} ${version} (${license})\n\n${text}\n`);
  }
  return parts.join('\n');
}
