// SPDX-License-Identifier: Apache-2.0
// Text from others: names, errors, notes.

/** Control characters, and those that change the direction of the text around them, become visible. */
export function printable(text: string): string {
  return text.replace(/[\p{Cc}\u2028\u2029\u202a-\u202e\u2066-\u2069]/gu, (character) =>
    character === '\n' || character === '\t' ? ' ' : '\ufffd',
  );
}

export function Foreign({ text }: { text: string }) {
  return <bdi>{printable(text)}</bdi>;
}
