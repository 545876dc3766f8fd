// SPDX-License-Identifier: Apache-2.0
// The page where it shows one view of a graph, in a browser window of its own.
import { useEffect } from 'react';
import { openView } from '../canvas/actions';
import { beginGraphs, openGraph, useGraphStore, useSnapshot } from '../canvas/graph_store';
import { watchDatasets } from '../panels/data_list';
import type { View } from '../view/view';
import { ViewPane } from '../view/view_pane';
import { useViews } from '../view/views';
import { Foreign } from './foreign';
import { useServer } from './server';
import type { ViewAddress } from './view_address';

export function ViewWindow({
  address: { graph, view },
  onKey,
}: {
  readonly address: ViewAddress;
  readonly onKey: (key: string, view: View) => boolean;
}) {
  const connection = useServer();
  const session = useGraphStore((s) => s.session);
  const snapshot = useSnapshot();
  const shown = useViews(({ views }) => views[0]);
  const isLoaded = snapshot?.isLoaded === true;

  useEffect(() => {
    document.title = `${view} of ${graph}, Galaxy`;
    const ends = [
      beginGraphs(connection),
      // The steps of simulations are told to whoever observes data.
      watchDatasets(
        connection,
        () => undefined,
        () => undefined,
      ),
    ];
    openGraph(graph);
    return () => {
      for (const end of ends) end();
    };
  }, [connection, graph, view]);
  useEffect(() => {
    if (isLoaded) openView(view);
  }, [isLoaded, session, view]);

  if (snapshot?.isGone)
    return (
      <p className="empty" role="alert">
        The server has no graph <Foreign text={graph} />.
      </p>
    );
  return shown ? <ViewPane view={shown} shown onKey={onKey} /> : <p className="empty">Loading ...</p>;
}
