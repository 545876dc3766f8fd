// SPDX-License-Identifier: Apache-2.0
// What the search finds: commands, nodes of the graph that is open, views, and data.
import { type MenuItem, withWords } from '../canvas/menu_item';
import { kindOf, titleOf } from '../canvas/titles';
import type { GraphNode } from '../graph/nodes';
import { KEYS } from '../view/keys';
import type { View } from '../view/view';

export interface SearchItem extends MenuItem {
  readonly run: () => void;
}

/** What is on the page to be found, and what is done with it. */
export interface Searched {
  readonly view: View | undefined; // the one in front
  readonly views: readonly View[];
  readonly nodes: readonly GraphNode[];
  readonly datasets: readonly { readonly name: string; readonly typeText: string }[];
  readonly commands: readonly { readonly label: string; readonly keys: string; readonly run: () => void }[];
  readonly showView: (view: View) => void;
  readonly showNode: (id: string) => void;
  readonly viewData: (name: string) => void;
  /** Absent: no graph is open. */
  readonly addData?: ((name: string) => void) | undefined;
}

const SYMBOLS: Record<string, string> = { ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓' };
export const keyText = (key: string): string => SYMBOLS[key] ?? key;

const capital = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

function viewCommands(view: View | undefined): Omit<SearchItem, 'key'>[] {
  if (!view) return [];
  return KEYS.flatMap(({ keys, help, actions }) =>
    actions.map((action, i) => ({
      group: 'Commands',
      label: keys.length > 1 ? `${capital(help)}: ${keyText(keys[i] ?? '')}` : capital(help),
      help: `key ${keyText(keys[i] ?? '')} in a view`,
      run: () => action(view),
    })),
  );
}

/** All that can be found, in groups. */
export function searchItems(on: Searched): readonly SearchItem[] {
  const found: Omit<SearchItem, 'key'>[] = [
    ...on.commands.map(({ label, keys, run }) => ({
      ...{ group: 'Commands', label, run },
      help: keys === '' ? '' : `key ${keys}`,
    })),
    ...viewCommands(on.view),
    ...on.nodes.map((node) => ({
      ...{ group: 'Nodes', label: titleOf(node), help: kindOf(node) },
      run: () => on.showNode(node.id),
    })),
    ...on.views.map((view) => ({
      ...{ group: 'Views', label: view.title, help: view.content },
      run: () => on.showView(view),
    })),
    ...on.datasets.map(({ name, typeText }) => ({
      ...{ group: 'Data: show in a view', label: name, help: typeText },
      run: () => on.viewData(name),
    })),
    ...(on.addData ? on.datasets : []).map(({ name, typeText }) => ({
      ...{ group: 'Data: add to the graph', label: name, help: typeText },
      run: () => on.addData?.(name),
    })),
  ];
  return found.map((item, i) => ({ ...item, key: String(i) }));
}

/** Those of them that have all the words that were typed, still in groups. */
export function foundItems(items: readonly SearchItem[], typed: string): readonly SearchItem[] {
  const groups = [...new Set(items.map((item) => item.group))];
  return groups.flatMap((group) =>
    withWords(
      items.filter((item) => item.group === group),
      typed,
    ),
  );
}
