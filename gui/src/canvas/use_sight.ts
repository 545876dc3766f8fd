// SPDX-License-Identifier: Apache-2.0
// What of the graph the canvas shows: all of it until the user moves or zooms the canvas, and always the nodes that the user has just added.
import { useNodesInitialized, useReactFlow, useStore } from '@xyflow/react';
import { useCallback, useEffect, useRef } from 'react';
import type { NodeGraph } from '../graph/nodes';
import type { CardNode } from './node_card';
import { type Rect, boundsOf, inSight } from './room';

/** How a graph is fitted into the canvas. */
export const FIT = { maxZoom: 1, padding: 0.08 };

export interface Sight {
  /** Fits the graph into the canvas, and again whenever the canvas gets another size. */
  readonly fit: () => void;
  /** The user has moved or zoomed the canvas: it stays so. */
  readonly release: () => void;
}

export function useSight(graph: NodeGraph, selection: readonly string[]): Sight {
  const flow = useReactFlow<CardNode>();
  const width = useStore((s) => s.width);
  const height = useStore((s) => s.height);
  const isDrawn = useNodesInitialized();
  const isFitted = useRef(true);
  const known = useRef<ReadonlySet<string>>(new Set());

  const fit = useCallback(() => {
    isFitted.current = true;
    void flow.fitView(FIT);
  }, [flow]);
  const release = useCallback(() => {
    isFitted.current = false;
  }, []);

  useEffect(() => {
    if (isFitted.current && width > 0 && height > 0 && known.current.size > 0) fit();
  }, [width, height, fit]);

  useEffect(() => {
    if (!isDrawn) return;
    const added = graph.nodes.map((n) => n.id).filter((id) => !known.current.has(id));
    known.current = new Set(graph.nodes.map((n) => n.id));
    // Nodes that others add are not selected: the canvas does not move for them.
    if (!added.some((id) => selection.includes(id))) return;
    const rects = added.flatMap((id): Rect[] => {
      const { position, measured } = flow.getNode(id) ?? {};
      return position && measured
        ? [{ ...position, width: measured.width ?? 0, height: measured.height ?? 0 }]
        : [];
    });
    const bounds = boundsOf(rects);
    const before = flow.getViewport();
    const wanted = bounds && inSight(before, { width, height }, bounds);
    if (!wanted || (wanted.x === before.x && wanted.y === before.y)) return;
    if (isFitted.current) fit();
    else void flow.setViewport(wanted);
  }, [isDrawn, graph, selection, flow, width, height, fit]);

  return { fit, release };
}
