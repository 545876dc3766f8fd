// SPDX-License-Identifier: Apache-2.0
// An entry of a list to choose from, and which entries fit what was typed.

export interface MenuItem {
  readonly key: string;
  readonly group: string;
  readonly label: string;
  readonly help: string;
}

/** Items whose label or group has all the words that were typed, those first whose label begins with the first of them. */
export function withWords<Item extends { readonly group: string; readonly label: string }>(
  items: readonly Item[],
  typed: string,
): readonly Item[] {
  const words = typed.toLowerCase().split(/\s+/).filter(Boolean);
  const found = items.filter((item) =>
    words.every((word) => `${item.label} ${item.group}`.toLowerCase().includes(word)),
  );
  const begins = (item: Item): boolean => item.label.toLowerCase().startsWith(words[0] ?? '');
  return words.length === 0 ? found : [...found.filter(begins), ...found.filter((item) => !begins(item))];
}
