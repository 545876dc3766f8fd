// SPDX-License-Identifier: Apache-2.0
// The states of nodes, as the server tells them (docs/graph.md, "States").
import { type Json, type JsonObject, member, objectsIn, textOf } from './json';
import { idOf } from './nodes';

export type StateKind =
  | 'incomplete'
  | 'blocked'
  | 'waiting'
  | 'queued'
  | 'running'
  | 'done'
  | 'stale'
  | 'failed';

export interface NodeState {
  readonly kind: StateKind;
  readonly text: string;
  readonly by: string; // the node that blocks it
  readonly done: number;
  readonly of: number;
  readonly generation: number | undefined;
  readonly seconds: number | undefined;
  readonly bytes: number | undefined;
  readonly rank: number | undefined;
  readonly leftOut: number; // steps that were not taken
  readonly showsOlder: boolean;
  readonly file: string;
  readonly told: JsonObject | undefined;
}

const KINDS: readonly StateKind[] = [
  'incomplete',
  'blocked',
  'waiting',
  'queued',
  'running',
  'done',
  'stale',
  'failed',
];
const SECTION_OF = new Map([
  ['dataset', 'Datasets'],
  ['view', 'Visualizations'],
  ['output', 'Outputs'],
] as const);

function numberIn(json: Json, key: string): number | undefined {
  const value = member(json, key);
  return typeof value === 'number' ? value : undefined;
}

/** Reads a state: the id of its node, and what it says. Undefined if it is none. */
export function stateOf(json: Json): [id: string, state: NodeState] | undefined {
  const kind = KINDS.find((k) => k === member(json, 'state'));
  const section = SECTION_OF.get(textOf(json, 'kind') as 'dataset');
  if (!kind || !section) return undefined;
  const told = member(json, 'told');
  const state: NodeState = {
    kind,
    text: textOf(json, 'text'),
    by: textOf(json, 'by'),
    done: numberIn(json, 'done') ?? 0,
    of: numberIn(json, 'of') ?? 0,
    generation: numberIn(json, 'generation'),
    seconds: numberIn(json, 'seconds'),
    bytes: numberIn(json, 'bytes'),
    rank: numberIn(json, 'rank'),
    leftOut: numberIn(json, 'left out') ?? 0,
    showsOlder: member(json, 'shows older') === true,
    file: textOf(json, 'file'),
    told:
      typeof told === 'object' && told !== null && !Array.isArray(told) ? (told as JsonObject) : undefined,
  };
  return [idOf(section, textOf(json, 'node')), state];
}

/** The states in the reply of `graph.get`. */
export function statesIn(reply: Json): Map<string, NodeState> {
  return new Map(
    objectsIn(member(reply, 'nodes')).flatMap((json) => [stateOf(json)].filter((s) => s !== undefined)),
  );
}

/** A size for people: "1.2 MB". */
export function bytesText(bytes: number): string {
  const units = ['B', 'kB', 'MB', 'GB', 'TB'];
  let value = bytes;
  let unit = 0;
  while (value >= 999.5 && unit < units.length - 1) {
    value /= 1000;
    unit++;
  }
  return `${unit === 0 || value >= 99.5 ? Math.round(value) : Number(value.toPrecision(2))} ${units[unit]}`;
}

/** A duration for people: "0.4 s", "2 min". */
export function secondsText(seconds: number): string {
  if (seconds < 0.0995) return `${Math.round(seconds * 1000)} ms`;
  return seconds < 99.5 ? `${Number(seconds.toPrecision(2))} s` : `${Math.round(seconds / 60)} min`;
}

/** What the footer of a node says beside the name of its state. `step`: of its data, if a simulation publishes these. */
export function factsText(state: NodeState, step?: number): string {
  const made = step !== undefined ? `step ${step}` : `generation ${state.generation}`;
  const facts = [
    state.kind === 'running' && state.of > 0 ? `${Math.round((100 * state.done) / state.of)} %` : '',
    state.kind === 'done' && state.generation !== undefined ? made : '',
    state.seconds !== undefined ? secondsText(state.seconds) : '',
    state.bytes !== undefined ? bytesText(state.bytes) : '',
    state.leftOut > 0 ? `${state.leftOut} left out` : '',
    state.showsOlder ? 'shows older' : '',
  ];
  return facts.filter((fact) => fact !== '').join(' · ');
}
