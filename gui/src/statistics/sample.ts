// SPDX-License-Identifier: Apache-2.0
// What one reply of the server's verb `stat` says, as numbers with names.
import { type JsonObject, numberOf, objectOf, objectsOf, textOf } from '../wire/json';

/** What is told now, whatever was before. */
export type Gauge = 'memory by rank' | 'memory by tenant' | 'memory by purpose' | 'evaluation';
/** What is counted from the server's start, or from a client's, so that only its growth says what happens now. */
export type Counter = 'rays' | 'messages' | 'frames' | 'client bytes';
export type Kind = Gauge | Counter;
export const KINDS: readonly Kind[] = [
  'memory by rank',
  'memory by tenant',
  'memory by purpose',
  'evaluation',
  'rays',
  'messages',
  'frames',
  'client bytes',
];

/** The numbers of one kind by the name of what they are of: a rank, a tenant, a client, a node. */
export type Values = ReadonlyMap<string, number>;

export interface Sample {
  /** Since the server's start, by its clock. */
  readonly seconds: number;
  readonly gauges: Readonly<Record<Gauge, Values>>;
  readonly counters: Readonly<Record<Counter, Values>>;
  /** The most memory that each rank may use; undefined: it is not the same for all. */
  readonly memoryLimit: number | undefined;
  /** Ranks that do not answer, with the seconds since which they have not. */
  readonly missing: Values;
}

/** Reads a reply of `stat`. `session` is that of this page; `evaluation` are the seconds of nodes, which come from elsewhere. */
export function sampleOf(reply: JsonObject, session: number, evaluation: Values): Sample {
  const ranks = objectsOf(reply, 'ranks');
  const nameOf = (rank: JsonObject): string => `rank ${numberOf(rank, 'rank')}`;
  const byRank = (valueOf: (rank: JsonObject) => number): Values =>
    new Map(ranks.map((rank) => [nameOf(rank), valueOf(rank)]));
  const lines = ranks.flatMap((rank) => objectsOf(objectOf(rank, 'memory'), 'by purpose'));
  const limits = new Set(ranks.map((rank) => numberOf(objectOf(rank, 'memory'), 'limit')));
  return {
    seconds: numberOf(reply, 'seconds'),
    gauges: {
      'memory by rank': byRank((rank) => numberOf(objectOf(rank, 'memory'), 'ledger')),
      'memory by tenant': sums(lines, (line) => textOf(line, 'tenant')),
      'memory by purpose': sums(lines, (line) => `${textOf(line, 'tenant')}: ${textOf(line, 'purpose')}`),
      evaluation,
    },
    counters: {
      rays: byRank((rank) => numberOf(objectOf(rank, 'rays'), 'traced')),
      messages: byRank((rank) => numberOf(rank, 'messages')),
      frames: new Map(
        objectsOf(reply, 'tenants').map((tenant) => [textOf(tenant, 'tenant'), numberOf(tenant, 'frames')]),
      ),
      'client bytes': new Map(
        objectsOf(reply, 'clients').map((client) => [
          clientName(client, session),
          numberOf(client, 'sent bytes'),
        ]),
      ),
    },
    memoryLimit: limits.size === 1 ? [...limits][0] : undefined,
    missing: new Map(objectsOf(reply, 'missing').map((rank) => [nameOf(rank), numberOf(rank, 'seconds')])),
  };
}

function sums(lines: readonly JsonObject[], nameOf: (line: JsonObject) => string): Values {
  const sum = new Map<string, number>();
  for (const line of lines) sum.set(nameOf(line), (sum.get(nameOf(line)) ?? 0) + numberOf(line, 'bytes'));
  return sum;
}

function clientName(client: JsonObject, session: number): string {
  const number = numberOf(client, 'session');
  return number === session ? `this page (${number})` : `${textOf(client, 'client')} (${number})`;
}
