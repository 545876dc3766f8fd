// SPDX-License-Identifier: Apache-2.0
// What an output or an input can be connected with: the list that the key `c` opens at a port.
import { type NodeGraph, edgeProblem } from '../graph/nodes';
import type { MenuItem } from './menu_item';
import { INPUT, titleOf } from './titles';

export interface PortItem extends MenuItem {
  readonly source: string;
  readonly target: string;
  readonly input: string;
}

/** `port`: `in:NAME` or `out`. */
export function portItems(graph: NodeGraph, id: string, port: string): readonly PortItem[] {
  const node = graph.byId.get(id);
  if (!node) return [];
  if (!port.startsWith(INPUT))
    return graph.nodes.flatMap((target) =>
      target.inputs
        .filter(
          (input) =>
            edgeProblem(graph, node, target, input) === '' && !input.sources.some((s) => s.node === id),
        )
        .map((input) => ({
          key: `${target.id} ${input.name}`,
          group: 'Connect to',
          label: `${titleOf(target)}: ${input.name || 'new input'}`,
          help: input.sources.length > 0 && !input.isMany ? `instead of ${input.sources[0]?.name ?? ''}` : '',
          ...{ source: id, target: target.id, input: input.name },
        })),
    );
  const input = node.inputs.find((i) => i.name === port.slice(INPUT.length));
  if (!input) return [];
  return graph.nodes
    .filter(
      (source) =>
        edgeProblem(graph, source, node, input) === '' && !input.sources.some((s) => s.node === source.id),
    )
    .map((source) => ({
      ...{ key: source.id, group: 'Connect with', label: titleOf(source), help: source.gives ?? '' },
      ...{ source: source.id, target: id, input: input.name },
    }));
}
