// SPDX-License-Identifier: Apache-2.0
// Onto which values the picture in front stretches the maps of a look. A view widens its `data range` with each step since it was opened, so
// this can be more than what the data have now.
import { useMemo, useSyncExternalStore } from 'react';
import { useSnapshot } from '../canvas/graph_store';
import type { GraphNode } from '../graph/nodes';
import { idOf, looksOf } from '../overlay/looks';
import { useViews } from '../view/views';
import type { Span } from './points';

const NOTHING = (): (() => void) => () => undefined;

/** Undefined: the view in front does not show the look, or has no picture of it yet. */
export function useRangeInView(look: GraphNode): Span | undefined {
  const snapshot = useSnapshot();
  const front = useViews(({ views, active }) => views.find(({ id }) => id === active));
  const of = front?.ofGraph;
  const view = of && of.graph === snapshot?.name ? front : undefined;
  const subscribe = useMemo(
    () => (view ? (listener: () => void) => view.subscribe(listener) : NOTHING),
    [view],
  );
  const seen = useSyncExternalStore(subscribe, () => view?.seen ?? null);
  const all = useMemo(() => (of && snapshot ? looksOf(snapshot.document, of.view) : []), [of, snapshot]);
  const shown = all.find((one) => idOf(one) === look.id);
  return (shown && seen?.ranges[shown.index]) ?? undefined;
}
