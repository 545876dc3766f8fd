// SPDX-License-Identifier: Apache-2.0
// What the server's statistics were in the last ten minutes.
import type { Counter, Kind, Sample, Values } from './sample';

export const TEN_MINUTES = 600; // seconds

export interface Row {
  /** In seconds since 1970, by a clock that never goes back. */
  readonly time: number;
  /** Undefined: nothing is known of this time, as there was no connection or nobody asked. */
  readonly sample: Sample | undefined;
  /** How fast the counters grew since the row before. What has no such row is not in it. */
  readonly rates: Readonly<Record<Counter, Values>>;
}

const NO_RATES: Row['rates'] = {
  rays: new Map(),
  messages: new Map(),
  frames: new Map(),
  'client bytes': new Map(),
};

/** The rows with one more. `sample` undefined: from here on nothing is known, until the next row. */
export function withRow(rows: readonly Row[], time: number, sample: Sample | undefined): readonly Row[] {
  const last = rows[rows.length - 1];
  if (!sample && !last?.sample) return rows;
  const rates = sample && last?.sample ? ratesOf(last.sample, sample) : NO_RATES;
  return [...rows.filter((row) => row.time >= time - TEN_MINUTES), { time, sample, rates }];
}

/** The growth of the counters per second. */
function ratesOf(before: Sample, after: Sample): Row['rates'] {
  const seconds = after.seconds - before.seconds;
  if (seconds <= 0) return NO_RATES; // The server has been started again.
  const rates = (counter: Counter): Values => {
    const known = before.counters[counter];
    return new Map(
      [...after.counters[counter]].flatMap(([name, count]): [string, number][] => {
        const was = known.get(name);
        return was === undefined || count < was ? [] : [[name, (count - was) / seconds]];
      }),
    );
  };
  return {
    rays: rates('rays'),
    messages: rates('messages'),
    frames: rates('frames'),
    'client bytes': rates('client bytes'),
  };
}

/** What a chart shows of a row: the values of a gauge, or the rates of a counter. */
export function valuesOf(row: Row, kind: Kind): Values {
  if (isCounter(kind)) return row.rates[kind];
  return row.sample?.gauges[kind] ?? new Map();
}

/** The counts of a counter, from their beginning; none of a gauge. */
export function totalsOf(row: Row, kind: Kind): Values {
  return (isCounter(kind) && row.sample?.counters[kind]) || new Map();
}

export function isCounter(kind: Kind): kind is Counter {
  return kind in NO_RATES;
}
