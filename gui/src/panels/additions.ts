// SPDX-License-Identifier: Apache-2.0
// Elements that buttons add to a list: planes through the middle of the data's box, and values in the middle of their range.
import { type Json, isList, member } from '../graph/json';
import type { ValueType } from '../graph/value_type';
import { spanIn } from '../maps/look_maps';
import { isPlane, middleOf, diagonalOf, roundedTo } from '../overlay/plane';
import type { Box } from '../view/camera';
import type { Vec3 } from '../view/vector';

export interface Addition {
  /** On its button, and what the button does. */
  readonly label: string;
  readonly help: string;
  /** The element for data that `data.info` describes; undefined: these data have no box, or no range. */
  readonly of: (info: Json) => Json | undefined;
}

const isPoint = (value: Json | undefined): value is readonly number[] =>
  isList(value) && value.length === 3 && value.every((n) => typeof n === 'number');

/** The box of a dataset as `data.info` says it; undefined: it has none. */
export function boxIn(info: Json): Box | undefined {
  const box = member(info, 'box');
  const [low, high] = isList(box) ? box : [];
  return isPoint(low) && isPoint(high) ? [low as unknown as Vec3, high as unknown as Vec3] : undefined;
}

function planeAcross(axis: 0 | 1 | 2, info: Json): Json | undefined {
  const box = boxIn(info);
  if (!box) return undefined;
  const at = roundedTo(middleOf(box)[axis], diagonalOf(box) / 1e4);
  const plane = [0, 1, 2].map((i) => (i === axis ? 1 : 0));
  return isPlane([...plane, at]) ? [...plane, at] : undefined;
}

function middleValue(info: Json): Json | undefined {
  const span = spanIn(member(info, 'range'));
  return span && roundedTo((span[0] + span[1]) / 2, (span[1] - span[0]) / 1000);
}

const PLANES = (['x', 'y', 'z'] as const).map(
  (name, axis): Addition => ({
    label: `+ ${name}`,
    help: `Add a plane across ${name}, through the middle of the data's box`,
    of: (info) => planeAcross(axis as 0 | 1 | 2, info),
  }),
);
const VALUES: readonly Addition[] = [
  { label: '+', help: "Add a value in the middle of the data's range", of: middleValue },
];

/** What buttons can add to values of a type: to lists of planes [a, b, c, d], and to lists of any numbers. */
export function additionsFor(type: ValueType): readonly Addition[] {
  if (type.kind !== 'list') return [];
  if (type.of.kind === 'vector') return type.of.names.join(' ') === 'a b c d' ? PLANES : [];
  return type.of.kind === 'number' && !type.of.isInteger && Object.keys(type.of.range).length === 0
    ? VALUES
    : [];
}
