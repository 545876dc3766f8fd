// SPDX-License-Identifier: Apache-2.0
// The place of the graph: its bar and its canvas.
import { useEffect } from 'react';
import { messageOf } from '../graph/session';
import { useDatasets } from '../panels/data_list';
import type { Connection } from '../wire/connection';
import { openView } from './actions';
import {
  beginGraphs,
  dataTypeOf,
  openGraph,
  refreshGraphs,
  useGraphStore,
  useNodeGraph,
  useSnapshot,
} from './graph_store';
import { GraphBar } from './graph_bar';
import { GraphCanvas } from './graph_canvas';

const KEPT = 'galaxy graph'; // in sessionStorage: the graph that this tab shows, to be opened again after a reload

/** Opens the graph that this tab has shown before, or the first there is. */
async function openFirst(): Promise<void> {
  const graphs = await refreshGraphs();
  const kept = sessionStorage.getItem(KEPT);
  const name = graphs.find((g) => g.name === kept)?.name ?? graphs[0]?.name;
  if (name !== undefined && !useGraphStore.getState().session) openGraph(name);
}

const fail = (error: unknown): void => useGraphStore.getState().say(messageOf(error));

export function GraphArea({ connection }: { readonly connection: Connection }) {
  const { session, setLive } = useGraphStore();
  const isLoaded = useSnapshot()?.isLoaded === true;
  const firstView = useNodeGraph().nodes.find((node) => node.role === 'view')?.name;
  const datasets = useDatasets(fail);

  useEffect(() => {
    const first = (): void => {
      if (connection.state.kind === 'open') openFirst().catch(fail);
    };
    first();
    const ends = [beginGraphs(connection), connection.onState(first)];
    return () => {
      for (const end of ends) end();
    };
  }, [connection]);
  useEffect(() => {
    if (session) sessionStorage.setItem(KEPT, session.name);
  }, [session]);
  useEffect(() => {
    setLive(
      datasets.map((d) => ({
        name: d.name,
        type: dataTypeOf(d.type),
        typeText: d.type,
        isShared: d.shared,
        generation: d.generation,
      })),
    );
  }, [datasets, setLive]);
  // A graph is evaluated for what shows it, so its first view comes with it.
  useEffect(() => {
    if (isLoaded && firstView !== undefined) openView(firstView);
    // Only when another graph is opened: a view that the user has closed stays closed.
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [isLoaded, session]);

  return (
    <div className="graph-area">
      <GraphBar />
      {session ? (
        <GraphCanvas />
      ) : (
        <p className="empty">
          No graph is open. A graph says what is shown and how it is made: make one with New, or open a state
          file as one with Open.
        </p>
      )}
    </div>
  );
}
