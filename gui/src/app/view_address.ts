// SPDX-License-Identifier: Apache-2.0
// The address of a view that has a browser window of its own: `#view=GRAPH/VIEW`. It says what is shown and not who looks.

export interface ViewAddress {
  readonly graph: string;
  readonly view: string;
}

/** The view that the fragment of an address names; undefined: it names none. Names of graphs have no `/`. */
export function viewIn(fragment: string): ViewAddress | undefined {
  const [, graph, view] =
    /^([^/]+)\/(.+)$/s.exec(new URLSearchParams(fragment.slice(1)).get('view') ?? '') ?? [];
  return graph !== undefined && view !== undefined ? { graph, view } : undefined;
}

export function fragmentOf({ graph, view }: ViewAddress): string {
  return `#view=${encodeURIComponent(graph)}/${encodeURIComponent(view)}`;
}

/**
 * Opens a view in a browser window of its own. The browser gives that window a copy of what this tab keeps (sessionStorage), and so it gets
 * in with the same token. Returns false if the browser does not allow it.
 */
export function openWindow(address: ViewAddress): boolean {
  const opened = window.open(fragmentOf(address), '_blank', 'popup,width=960,height=720');
  return opened !== null;
}
