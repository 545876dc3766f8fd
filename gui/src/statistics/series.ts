// SPDX-License-Identifier: Apache-2.0
// Which lines a chart has, and the values of each.
import { type Row, valuesOf } from './history';
import type { Kind, Values } from './sample';

/** As many lines can be told from each other by colour and dashes. */
export const MOST_LINES = 8;
/** The look of the line that stands for all that have none of their own. */
export const OTHERS = MOST_LINES;

export interface Line {
  /** What it is of. */
  readonly name: string;
  /** Which look it has: 0 to MOST_LINES - 1, or OTHERS. */
  readonly look: number;
  /** One for each row; null: it was not known. */
  readonly values: readonly (number | null)[];
}

/** The looks that names have. They keep them as long as they are shown, so that no line changes its colour. */
export type Looks = ReadonlyMap<string, number>;

const byName = (a: string, b: string): number => a.localeCompare(b, 'en', { numeric: true });

/** The names with the largest values, at most MOST_LINES, in the order of names. */
export function shownNames(rows: readonly Row[], kind: Kind): readonly string[] {
  const most = new Map<string, number>();
  for (const row of rows)
    for (const [name, value] of valuesOf(row, kind)) most.set(name, Math.max(most.get(name) ?? 0, value));
  return [...most]
    .sort(([a, x], [b, y]) => y - x || byName(a, b))
    .slice(0, MOST_LINES)
    .map(([name]) => name)
    .sort(byName);
}

/** Gives looks to names: those that they had, and free ones to new names. */
export function looksFor(names: readonly string[], before: Looks): Looks {
  const kept = new Map(
    names.flatMap((n): [string, number][] => (before.has(n) ? [[n, before.get(n) as number]] : [])),
  );
  const free = Array.from({ length: MOST_LINES }, (_, look) => look).filter(
    (look) => ![...kept.values()].includes(look),
  );
  return new Map(names.map((name) => [name, kept.get(name) ?? free.shift() ?? OTHERS]));
}

/** The lines of a chart: one for each name that has a look, and one with the sum of all others if there are any. */
export function linesOf(rows: readonly Row[], kind: Kind, looks: Looks): readonly Line[] {
  const columns = rows.map((row) => valuesOf(row, kind));
  const lines = [...looks].map(
    ([name, look]): Line => ({ name, look, values: columns.map((values) => values.get(name) ?? null) }),
  );
  const others = columns.map((values) => othersOf(values, looks));
  const count = new Set(columns.flatMap((values) => [...values.keys()])).size - looks.size;
  if (count <= 0) return lines;
  return [...lines, { name: count === 1 ? '1 other' : `${count} others`, look: OTHERS, values: others }];
}

/** The sum over all that have no look; null: there are none. */
export function othersOf(values: Values, looks: Looks): number | null {
  const others = [...values].filter(([name]) => !looks.has(name));
  return others.length === 0 ? null : others.reduce((sum, [, value]) => sum + value, 0);
}

/** The largest value of a line; null: it has none. */
export function mostOf(line: Line): number | null {
  return line.values.reduce((most, v) => (v === null ? most : Math.max(most ?? v, v)), null);
}
