// SPDX-License-Identifier: Apache-2.0
// What a Cinema database of a view can vary, and what is asked of it.
import type { JsonObject } from '../graph/json';
import { numberTexts } from '../overlay/legend';
import { isovaluesOf, type Look, planesOf } from '../overlay/looks';
import { withinBox } from '../overlay/plane';
import type { Box } from '../view/camera';
import type { Seen } from '../view/remote_window';

/** Something that can be varied, as the form shows it. */
export interface Axis {
  readonly id: string;
  readonly label: string;
  /** Of the sweep's axis, without its values; undefined: the steps of the data. */
  readonly entry: JsonObject | undefined;
  readonly isChosen: boolean;
  // What was typed.
  readonly from: string;
  readonly to: string;
  readonly count: string;
}

const MOST = 10_000; // pictures of a step
const MOST_STEPS = 1_000_000;

/** The last step of a path is the place in a list. */
const placeOf = (path: readonly (string | number)[]): number | undefined => {
  const last = path[path.length - 1];
  return typeof last === 'number' ? last : undefined;
};

function axisOf(entry: JsonObject, label: string, ends: readonly [number, number]): Axis {
  const id = [entry['axis'], entry['operator'], entry['index']]
    .filter((part) => part !== undefined)
    .join(' ');
  const [from = '', to = ''] = numberTexts(ends, ends[1] - ends[0]);
  return { id, label, entry, isChosen: false, from, to, count: '5' };
}

function axesOfLook(look: Look, operator: number, box: Box | null, range: Seen['ranges'][number]): Axis[] {
  const isovalues = isovaluesOf(look).flatMap(({ path, label, value }) => {
    const index = placeOf(path);
    const entry = { axis: 'isovalue', operator, index: index ?? 0 };
    return index === undefined ? [] : [axisOf(entry, label, range ?? [value, value + 1])];
  });
  const planes = planesOf(look).flatMap(({ path, label, kind, plane }) => {
    const index = placeOf(path);
    const [a, b, c, d] = plane;
    const end = (at: number): number => (box ? withinBox([a, b, c, at], box)[3] : d + Math.sign(at));
    const entry = { axis: kind, operator, index: index ?? 0 };
    return index === undefined ? [] : [axisOf(entry, label, [end(-Infinity), end(Infinity)])];
  });
  return [...isovalues, ...planes];
}

/** All that can be varied of a view, the turn about its middle chosen. */
export function axesOfView(looks: readonly Look[], { box, ranges }: Pick<Seen, 'box' | 'ranges'>): Axis[] {
  const phi = axisOf({ axis: 'phi' }, 'phi: turn, in degrees', [0, 315]);
  const theta = axisOf({ axis: 'theta' }, 'theta: raise, in degrees', [-30, 30]);
  return [
    { ...phi, isChosen: true, count: '8' },
    { ...theta, count: '3' },
    ...looks.flatMap((look, operator) => axesOfLook(look, operator, box, ranges[look.index] ?? null)),
    {
      id: 'time',
      label: 'steps of the data',
      entry: undefined,
      isChosen: false,
      from: '',
      to: '',
      count: '10',
    },
  ];
}

const isNumber = (text: string): boolean => text.trim() !== '' && Number.isFinite(Number(text));

/** What is wrong with an axis; empty: nothing, or it is not chosen. */
export function axisProblem(axis: Axis): string {
  if (!axis.isChosen) return '';
  const most = axis.entry ? MOST : MOST_STEPS;
  const least = axis.entry ? 2 : 1;
  const count = Number(axis.count);
  if (axis.entry && !(isNumber(axis.from) && isNumber(axis.to))) return 'expected numbers';
  if (axis.entry && Number(axis.from) === Number(axis.to)) return 'expected two different numbers';
  return Number.isInteger(count) && count >= least && count <= most
    ? ''
    : `expected a count of ${least} to ${most}`;
}

/** The sweep of the chosen axes, and how many steps of the data it is made of. */
export function sweepOf(axes: readonly Axis[]): { sweep: JsonObject; steps: number } {
  const chosen = axes.filter((axis) => axis.isChosen);
  const time = chosen.find((axis) => !axis.entry);
  const entries = chosen.flatMap(({ entry, from, to, count }, i): JsonObject[] => {
    if (!entry) return [];
    // Columns of a table have different names.
    const before = chosen.slice(0, i).filter((other) => other.entry?.['axis'] === entry['axis']).length;
    const name = before > 0 ? { name: `${String(entry['axis'])} ${before + 1}` } : {};
    return [{ ...entry, ...name, from: Number(from), to: Number(to), count: Number(count) }];
  });
  return {
    sweep: { axes: [...(time ? [{ axis: 'time' }] : []), ...entries] },
    steps: time ? Number(time.count) : 1,
  };
}
