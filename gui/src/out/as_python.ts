// SPDX-License-Identifier: Apache-2.0
// The command that saves the graph in front as a Python program.
import { download, stem } from '../app/files';
import { useGraphStore } from '../canvas/graph_store';
import type { Size } from '../view/camera';
import { PASSES } from '../view/view';
import { useViews } from '../view/views';
import { pythonScript } from './python_script';

/** HOST:PORT of the page's server. */
function address(): string {
  const { hostname, port, protocol } = window.location;
  return `${hostname}:${port || (protocol === 'https:' ? 443 : 80)}`;
}

/** The sizes in which the page shows views of a graph. */
function sizesOf(graph: string): ReadonlyMap<string, Size> {
  const shown = useViews.getState().views.flatMap((view): [string, Size][] => {
    const { ofGraph, seen } = view;
    return ofGraph?.graph === graph && seen ? [[ofGraph.view, seen.size]] : [];
  });
  return new Map(shown);
}

/** Saves a program that makes the graph in front anew, and the pictures of its views as the page shows them. */
export function savePython(): void {
  const { session, catalogue } = useGraphStore.getState();
  if (!session?.snapshot.isLoaded) return;
  const { name: graph, snapshot } = session;
  const script = pythonScript({
    ...{ graph, catalogue, document: snapshot.document, address: address() },
    ...{ sizes: sizesOf(graph), rays: PASSES },
  });
  download(`${stem(graph)}.py`, script, 'text/x-python');
}
