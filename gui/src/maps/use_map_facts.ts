// SPDX-License-Identifier: Apache-2.0
// Asks the server for the histogram of a look's data, anew with each generation of these.
import { useEffect, useRef, useState } from 'react';
import { useGraphStore, useNodeGraph, useSnapshot } from '../canvas/graph_store';
import { type Json, member, objectsIn, textOf } from '../graph/json';
import type { GraphNode } from '../graph/nodes';
import { messageOf } from '../graph/session';
import type { Connection } from '../wire/connection';
import { statement } from '../wire/statement';
import { type MapData, type MapFacts, SeenRanges, histogramOf, isSame, mapDataOf } from './histogram';
import { spanIn } from './look_maps';

const BINS = 128;
const seen = new SeenRanges();

/** The field of geometry that a look names, as `data.info` describes it; undefined: it is the dataset's own values. */
async function fieldOf(connection: Connection, data: MapData): Promise<Json | undefined> {
  if (data.array === '') return undefined;
  const reply = (await connection.request(statement('data.info', [data.dataset]))) as Json;
  const info = objectsIn(member(reply, 'datasets'))[0] ?? {};
  const field = objectsIn(member(info, 'fields')).find((f) => textOf(f, 'name') === data.array);
  if (!field && textOf(info, 'array') !== data.array) throw new Error(`These data have no ${data.array}.`);
  return field;
}

async function asked(connection: Connection, data: MapData, generation: number): Promise<MapFacts> {
  const field = await fieldOf(connection, data);
  if (field) {
    const isOne = data.component === undefined || member(field, 'components') === 1;
    const range = isOne ? spanIn(member(field, 'range')) : undefined;
    return { data, generation, range, histogram: undefined };
  }
  const words = [data.dataset, BINS, ...(data.component === undefined ? [] : [data.component])];
  const histogram = histogramOf((await connection.request(statement('data.histogram', words))) as Json);
  return { data, generation, range: histogram?.range, histogram };
}

export interface FactsOfLook {
  readonly data: MapData | undefined;
  readonly facts: MapFacts | undefined;
  /** Of all generations that this page has asked for. */
  readonly seen: MapFacts['range'];
  /** Why there are none. */
  readonly problem: string;
}

/** One question is under way at a time. Until it is answered, the generation before is shown, and says which it is. */
export function useMapFacts(look: GraphNode): FactsOfLook {
  const connection = useGraphStore((s) => s.connection);
  const snapshot = useSnapshot();
  const graph = useNodeGraph();
  const input = graph.byId.get(look.inputs[0]?.sources[0]?.node ?? '');
  const data = mapDataOf(look, input, snapshot?.name ?? '');
  const generation = data && snapshot?.states.get(data.node)?.generation;
  const key = data && generation !== undefined ? JSON.stringify([data, generation]) : '';
  const [answer, setAnswer] = useState<{ data: MapData; facts?: MapFacts; problem: string }>();
  const isAsking = useRef(false);
  const askedFor = useRef('');
  const [turn, setTurn] = useState(0); // Each lets the next question go.
  const next = (): void => setTurn((n) => n + 1);

  useEffect(() => connection?.onState((state) => state.kind === 'open' && next()), [connection]);
  useEffect(() => {
    if (connection?.state.kind !== 'open' || key === '' || isAsking.current || askedFor.current === key)
      return;
    const [of, step] = JSON.parse(key) as [MapData, number];
    isAsking.current = true;
    askedFor.current = key;
    asked(connection, of, step)
      .then(
        (facts) => {
          if (facts.range) seen.add(of, facts.range);
          setAnswer({ data: of, facts, problem: '' });
        },
        (error: unknown) => {
          if (connection.state.kind === 'open') setAnswer({ data: of, problem: messageOf(error) });
          else askedFor.current = ''; // It is asked again on the next connection.
        },
      )
      .finally(() => {
        isAsking.current = false;
        next();
      });
  }, [connection, key, turn]);

  const own = data && answer && isSame(answer.data, data) ? answer : undefined;
  return { data, facts: own?.facts, seen: data && seen.of(data), problem: own?.problem ?? '' };
}
