// SPDX-License-Identifier: Apache-2.0
// While an edge is dragged from a port: at which ports it may end.
import { create } from 'zustand';
import { type NodeGraph, edgeProblem } from '../graph/nodes';
import { INPUT, OUTPUT } from './titles';

export interface DraggedPort {
  readonly node: string;
  readonly port: string; // `in:NAME` or `out`
}

const keyOf = (node: string, port: string): string => `${port} ${node}`;

/** The ports at which an edge from a port may end, and that port itself. */
export function fittingPorts(graph: NodeGraph, from: DraggedPort): ReadonlySet<string> {
  const found = new Set([keyOf(from.node, from.port)]);
  const start = graph.byId.get(from.node);
  const input = start?.inputs.find((i) => INPUT + i.name === from.port);
  for (const node of graph.nodes) {
    if (!start) break;
    if (input) {
      if (node.hasOutput && edgeProblem(graph, node, start, input) === '') found.add(keyOf(node.id, OUTPUT));
    } else
      for (const other of node.inputs)
        if (edgeProblem(graph, start, node, other) === '') found.add(keyOf(node.id, INPUT + other.name));
  }
  return found;
}

interface Dragging {
  /** Undefined: no edge is dragged. */
  readonly fitting: ReadonlySet<string> | undefined;
}

const useDragging = create<Dragging>(() => ({ fitting: undefined }));

export function beginDragging(graph: NodeGraph, from: DraggedPort): void {
  useDragging.setState({ fitting: fittingPorts(graph, from) });
}

export function endDragging(): void {
  useDragging.setState({ fitting: undefined });
}

/** What is added to the class of a port's elements while an edge is dragged. */
export function useFitClass(node: string, port: string): string {
  return useDragging(({ fitting }) =>
    fitting === undefined ? '' : fitting.has(keyOf(node, port)) ? ' fits' : ' unfit',
  );
}
