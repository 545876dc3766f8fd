// SPDX-License-Identifier: Apache-2.0
// How nodes are called for people, and their ports on the canvas.
import { textOf } from '../graph/json';
import { type GraphNode, lookType } from '../graph/nodes';

/** What ports are called on the canvas: `in:NAME` and `out`. */
export const INPUT = 'in:';
export const OUTPUT = 'out';

export function titleOf(node: GraphNode): string {
  return node.name || textOf(node.entry, 'dataset') || 'look';
}

export function kindOf(node: GraphNode): string {
  if (node.role === 'live') return `Live ${textOf(node.entry, 'type') || 'data'}`;
  if (node.role === 'file') return `${textOf(node.entry, 'type') || 'Data'} of a file`;
  if (node.role === 'filter') return textOf(node.entry, 'filter');
  if (node.role === 'look') return `${lookType(node.entry) ?? textOf(node.entry, 'type')} look`;
  if (node.role === 'view') return 'View';
  return textOf(node.entry, 'type') || 'Output';
}
