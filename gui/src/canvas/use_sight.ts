// SPDX-License-Identifier: Apache-2.0
// What of the graph the canvas shows: all of it, or as much as can be read, until the user moves or zooms the canvas; and always the
// nodes that the user has just added or has searched for.
import { useNodesInitialized, useReactFlow, useStore } from '@xyflow/react';
import { useCallback, useEffect, useRef } from 'react';
import type { NodeGraph } from '../graph/nodes';
import type { GraphSession } from '../graph/session';
import type { CardNode } from './node_card';
import { useGraphStore } from './graph_store';
import { READABLE, readableViewport } from './readable';
import { type Rect, boundsOf, inSight } from './room';

/**
 * How a whole graph is fitted into the canvas when the user asks for it. Within 40 pixels of its edges, React Flow moves the canvas while an
 * edge is dragged.
 */
export const FIT = { maxZoom: 1, padding: { x: '40px', top: '40px', bottom: '44px' } } as const;
const BUTTONS = 32; // pixels at the lower edge of the canvas, which its buttons cover

export interface Sight {
  /** Fits the graph into the canvas as far as it can be read. This, and fitAll(), is done again when the canvas gets another size. */
  readonly fit: () => void;
  /** Fits all of the graph into the canvas, however small it becomes. */
  readonly fitAll: () => void;
  /** The user has moved or zoomed the canvas: it stays so. */
  readonly release: () => void;
}

export function useSight(
  session: GraphSession | undefined,
  graph: NodeGraph,
  selection: readonly string[],
): Sight {
  const flow = useReactFlow<CardNode>();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height) - BUTTONS;
  const isDrawn = useNodesInitialized();
  // A card grows when the server says what it lacks.
  const selectedHeight = useStore((s) =>
    selection.reduce((sum, id) => sum + (s.nodeLookup.get(id)?.measured.height ?? 0), 0),
  );
  const own = useRef<readonly string[]>([]); // that the user has added last, while one of them is selected
  const fitted = useRef<'readable' | 'all' | 'no'>('readable');
  const known = useRef<ReadonlySet<string>>(new Set());
  const now = useRef({ selection, width, height });
  useEffect(() => {
    now.current = { selection, width, height };
  });

  const rectsOf = useCallback(
    (ids: readonly string[]): Rect[] =>
      ids.flatMap((id) => {
        const card = flow.getNode(id);
        const { width: w, height: h } = card?.measured ?? {};
        return card && w && h ? [{ ...card.position, width: w, height: h }] : [];
      }),
    [flow],
  );
  const fitAll = useCallback(() => {
    fitted.current = 'all';
    own.current = [];
    void flow.fitView(FIT);
  }, [flow]);
  const fit = useCallback(() => {
    fitted.current = 'readable';
    const ids = flow.getNodes().map((n) => n.id);
    const canvas = now.current;
    const all = boundsOf(rectsOf(ids));
    const chosen = boundsOf(rectsOf(canvas.selection));
    const newest = boundsOf(rectsOf(ids.slice(-1)));
    const focus = chosen ?? newest;
    if (all && focus && canvas.width > 0) void flow.setViewport(readableViewport(all, focus, canvas));
  }, [flow, rectsOf]);
  const release = useCallback(() => {
    fitted.current = 'no';
    own.current = [];
  }, []);

  useEffect(() => {
    if (known.current.size === 0) return;
    if (fitted.current === 'readable') fit();
    else if (fitted.current === 'all') fitAll();
  }, [width, height, fit, fitAll]);

  // Another graph begins anew.
  useEffect(() => {
    known.current = new Set();
    fitted.current = 'readable';
  }, [session]);

  useEffect(() => {
    const ids = graph.nodes.map((n) => n.id);
    if (!isDrawn || rectsOf(ids).length < ids.length) return;
    const added = ids.filter((id) => !known.current.has(id));
    const isOpened = known.current.size === 0;
    known.current = new Set(ids);
    // Nodes that others add are not selected: the canvas does not move for them.
    if (added.some((id) => selection.includes(id))) own.current = added;
    else if (isOpened && added.length > 0) fit();
    if (!own.current.some((id) => selection.includes(id))) own.current = [];
    const bounds = boundsOf(rectsOf(own.current));
    const before = flow.getViewport();
    const wanted = bounds && inSight(before, { width, height }, bounds);
    if (!wanted || (wanted.x === before.x && wanted.y === before.y)) return;
    if (fitted.current === 'no') void flow.setViewport(wanted);
    else fit();
  }, [isDrawn, graph, session, selection, selectedHeight, flow, width, height, fit, rectsOf]);

  // A node that was searched for comes into the middle, large enough to be read.
  const { sought, seek } = useGraphStore();
  useEffect(() => {
    const card = sought === undefined ? undefined : flow.getNode(sought);
    if (!card) return;
    seek(undefined);
    fitted.current = 'no';
    const { width: w = 0, height: h = 0 } = card.measured ?? {};
    const zoom = Math.max(flow.getZoom(), READABLE);
    void flow.setCenter(card.position.x + w / 2, card.position.y + h / 2, { zoom });
  }, [sought, seek, flow]);

  return { fit, fitAll, release };
}
