// SPDX-License-Identifier: Apache-2.0
// Statements, docs/protocol.md section 4: `VERB [ARGUMENTS]`.
import type { JsonObject } from './json';

/** Writes a word so that the server reads it as one: as a JSON string where that is needed. */
export function asWord(text: string): string {
  return text === '' || /[ \t\r\n";]/.test(text) || text.startsWith('{') ? JSON.stringify(text) : text;
}

/** `statement('viewer.set', [1], document)`: a verb, its words and its JSON object. */
export function statement(verb: string, words: (string | number)[] = [], json?: JsonObject): string {
  const parts = [verb, ...words.map((word) => asWord(String(word)))];
  if (json) parts.push(JSON.stringify(json));
  return parts.join(' ');
}
