// SPDX-License-Identifier: Apache-2.0
// How long the nodes of the graph that is open took when they were evaluated last.
import type { NodeState } from '../graph/states';
import type { Values } from './sample';

export class EvaluationTimes {
  private graph: string | undefined;
  private known: Values = new Map();

  /** The seconds of each node that a filter has made. While it is made anew, those of before count. */
  of(graph: string | undefined, states: ReadonlyMap<string, NodeState> = new Map()): Values {
    const before: Values = graph === this.graph ? this.known : new Map();
    this.graph = graph;
    this.known = new Map(
      [...states].flatMap(([id, { seconds }]): [string, number][] => {
        const name = id.slice(id.indexOf('/') + 1);
        const value = seconds ?? before.get(name);
        return value === undefined ? [] : [[name, value]];
      }),
    );
    return this.known;
  }
}
