// SPDX-License-Identifier: Apache-2.0
// What the data of the selected node are: box, range, points, generation, and what its filter tells.
import { useEffect, useState } from 'react';
import { Foreign } from '../app/foreign';
import { useGraphStore, useSnapshot } from '../canvas/graph_store';
import { type Json, type JsonObject, isList, isObject, member, objectsIn, textOf } from '../graph/json';
import type { GraphNode } from '../graph/nodes';
import { messageOf } from '../graph/session';
import { bytesText } from '../graph/states';
import { statement } from '../wire/statement';

const digits = (value: Json | undefined): string =>
  typeof value === 'number' ? String(Number(value.toPrecision(6))) : 'none';
const span = (value: Json | undefined): string =>
  isList(value) ? `${digits(value[0])} to ${digits(value[1])}` : 'none';
const point = (value: Json | undefined): string => (isList(value) ? value.map(digits).join(', ') : '');

/** The lines of the table for the description of a dataset by `data.info`. */
export function factsOf(info: Json): readonly (readonly [string, string])[] {
  const box = member(info, 'box');
  const mesh = member(info, 'mesh');
  const facts: (readonly [string, string | undefined])[] = [
    ['type', textOf(info, 'type')],
    ['generation', digits(member(info, 'generation'))],
    ['time', member(info, 'time') === undefined ? undefined : digits(member(info, 'time'))],
    ['box', isList(box) ? `${point(box[0])} to ${point(box[1])}` : 'none'],
    ['range', span(member(info, 'range'))],
    ['components', digits(member(info, 'components'))],
    [
      'points',
      isList(member(info, 'points')) ? (member(info, 'points') as Json[]).map(String).join(' × ') : undefined,
    ],
    [
      'mesh',
      isObject(mesh)
        ? `${digits(member(mesh, 'points'))} points, ${digits(member(mesh, 'cells'))} cells`
        : undefined,
    ],
    ['primitives', member(info, 'primitives') === undefined ? undefined : digits(member(info, 'primitives'))],
    ['partitions', digits(member(info, 'partitions'))],
    [
      'memory',
      typeof member(info, 'bytes') === 'number' ? bytesText(member(info, 'bytes') as number) : undefined,
    ],
    ['array', textOf(info, 'array') || undefined],
    ['file', textOf(info, 'file') || undefined],
    ...objectsIn(member(info, 'fields')).map((f): readonly [string, string] => [
      `field ${textOf(f, 'name')}`,
      span(member(f, 'range')),
    ]),
  ];
  return facts.flatMap(([name, text]) => (text === undefined ? [] : [[name, text] as const]));
}

/** What a filter told, without lists that are too long to read. */
function toldFacts(told: JsonObject | undefined): readonly (readonly [string, string])[] {
  return Object.entries(told ?? {})
    .filter(([key, value]) => key !== 'text' && JSON.stringify(value).length < 200)
    .map(([key, value]) => [key, typeof value === 'number' ? digits(value) : JSON.stringify(value)]);
}

export function DataTab({ node }: { node: GraphNode }) {
  const connection = useGraphStore((s) => s.connection);
  const snapshot = useSnapshot();
  const [info, setInfo] = useState<{
    id: string;
    facts: readonly (readonly [string, string])[];
    text: string;
  }>();
  const state = snapshot?.states.get(node.id);
  const name = node.role === 'live' ? node.name : `${snapshot?.name}/${node.name}`;
  const isData = node.role === 'live' || node.role === 'file' || node.role === 'filter';
  const generation = state?.generation;

  useEffect(() => {
    if (!connection || !isData || generation === undefined) return;
    let isWanted = true;
    connection.request(statement('data.info', [name])).then(
      (reply) => {
        const found = objectsIn(member(reply as Json, 'datasets'))[0];
        if (isWanted) setInfo({ id: node.id, facts: found ? factsOf(found) : [], text: '' });
      },
      (error: unknown) => {
        if (isWanted) setInfo({ id: node.id, facts: [], text: messageOf(error) });
      },
    );
    return () => {
      isWanted = false;
    };
  }, [connection, name, node.id, generation, isData]);

  const rows = [...(info?.id === node.id ? info.facts : []), ...toldFacts(state?.told)];
  return (
    <div className="data-tab">
      {rows.length === 0 && (
        <p className="weak">
          {info?.id === node.id && info.text !== '' ? info.text : 'There are no data of this node yet.'}
        </p>
      )}
      <table>
        <tbody>
          {rows.map(([key, text]) => (
            <tr key={key}>
              <th scope="row">
                <Foreign text={key} />
              </th>
              <td>
                <Foreign text={text} />
              </td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
