// SPDX-License-Identifier: Apache-2.0
// Copies of datasets: what a dataset is now, kept under another name.
import type { JsonObject } from '../wire/json';
import { numberOf, textOf } from '../wire/json';

/** A name for a copy that means nothing yet: "pressure copy", "pressure copy 2", ... */
export function copyName(name: string, taken: ReadonlySet<string>): string {
  const first = `${name} copy`;
  let copy = first;
  for (let count = 2; taken.has(copy); count++) copy = `${first} ${count}`;
  return copy;
}

/** What a user is told of a copy, given the reply of `data.copy`. */
export function keptText(name: string, copy: string, reply: JsonObject): string {
  const of = textOf(reply, 'stream') === '' ? '' : `step ${numberOf(reply, 'step')} of `;
  return `"${copy}" keeps ${of}"${name}"`;
}
