// SPDX-License-Identifier: Apache-2.0
// Places of nodes: each to the right of what it is made of.
import type { Position } from '../graph/changes';
import type { GraphNode, NodeGraph } from '../graph/nodes';
import { kindOf } from './titles';

export const COLUMN = 226;
const GAP = 28;

const IN_A_LINE = 19; // letters of a node's kind and of what it gives, about

/** How high a card is, as far as it can be told before it is drawn. */
export function heightOf(node: GraphNode): number {
  const isInALine = kindOf(node).length + (node.gives?.length ?? 0) <= IN_A_LINE;
  return (isInALine ? 92 : 113) + 25 * node.inputs.length;
}

/** Places for the nodes that have none, in columns by their distance from the sources, below what is there. */
export function placesFor(graph: NodeGraph, known: ReadonlyMap<string, Position>): Map<string, Position> {
  const columns = columnsOf(graph);
  const bottoms = new Map<number, number>();
  for (const [id, [x, y]] of known) {
    const column = Math.round(x / COLUMN);
    const node = graph.byId.get(id);
    const bottom = y + (node ? heightOf(node) : 0) + GAP;
    bottoms.set(column, Math.max(bottoms.get(column) ?? 0, bottom));
  }
  const places = new Map<string, Position>();
  for (const node of graph.nodes) {
    if (known.has(node.id)) continue;
    const column = columns.get(node.id) ?? 0;
    const y = bottoms.get(column) ?? 0;
    places.set(node.id, [column * COLUMN, y]);
    bottoms.set(column, y + heightOf(node) + GAP);
  }
  return places;
}

/** The length of the longest way to each node from a node without inputs. Edges of a cycle do not count. */
function columnsOf(graph: NodeGraph): Map<string, number> {
  const before = new Map<string, string[]>();
  for (const edge of graph.edges) before.set(edge.target, [...(before.get(edge.target) ?? []), edge.source]);
  const columns = new Map<string, number>();
  const visit = (id: string, path: ReadonlySet<string>): number => {
    const known = columns.get(id);
    if (known !== undefined) return known;
    const inner = new Set(path).add(id);
    const sources = (before.get(id) ?? []).filter((source) => !inner.has(source));
    const column = sources.reduce((most, source) => Math.max(most, 1 + visit(source, inner)), 0);
    columns.set(id, column);
    return column;
  };
  for (const node of graph.nodes) visit(node.id, new Set());
  return columns;
}

/** Places for all nodes, with few crossings of edges. The library that computes them is loaded when it is first asked for. */
export async function arranged(
  graph: NodeGraph,
  sizes: ReadonlyMap<string, { width: number; height: number }>,
): Promise<Map<string, Position>> {
  const { default: dagre } = await import('@dagrejs/dagre');
  const plan = new dagre.graphlib.Graph({ multigraph: true });
  plan.setGraph({ rankdir: 'LR', nodesep: GAP, ranksep: 36 });
  plan.setDefaultEdgeLabel(() => ({}));
  for (const node of graph.nodes)
    plan.setNode(node.id, {
      ...(sizes.get(node.id) ?? { width: 190, height: heightOf(node) }),
    });
  for (const edge of graph.edges) plan.setEdge(edge.source, edge.target, {}, edge.id);
  dagre.layout(plan);
  return new Map(
    graph.nodes.map((node): [string, Position] => {
      const { x, y, width, height } = plan.node(node.id);
      return [node.id, [x - width / 2, y - height / 2]];
    }),
  );
}
