// SPDX-License-Identifier: Apache-2.0
// Buttons beside a list of a look: each adds an element that suits the look's data.
import { useGraphStore, useNodeGraph } from '../canvas/graph_store';
import type { Property } from '../graph/catalogue';
import { find } from '../graph/edits';
import { type Json, isList, member, objectsIn } from '../graph/json';
import type { GraphNode } from '../graph/nodes';
import { messageOf } from '../graph/session';
import { type MapData, mapDataOf } from '../maps/histogram';
import type { Connection } from '../wire/connection';
import { statement } from '../wire/statement';
import { type Addition, additionsFor } from './additions';
import './add_buttons.css';

/** What `data.info` says of a look's data, with the range of the component that the look shows. */
async function infoOf(connection: Connection, { dataset, component }: MapData): Promise<Json> {
  const reply = (await connection.request(statement('data.info', [dataset]))) as Json;
  const info = objectsIn(member(reply, 'datasets'))[0] ?? {};
  if (component === undefined || member(info, 'components') === 1) return info;
  const counted = (await connection.request(statement('data.histogram', [dataset, 1, component]))) as Json;
  return { ...info, range: member(counted, 'range') ?? null };
}

interface AddButtonsProps {
  readonly node: GraphNode;
  readonly property: Property;
  readonly name: string; // of the key in the document
}

export function AddButtons({ node, property, name }: AddButtonsProps) {
  const { connection, session } = useGraphStore();
  const graph = useNodeGraph();
  const additions = node.role === 'look' ? additionsFor(property.type) : [];
  if (additions.length === 0) return null;
  const input = graph.byId.get(node.inputs[0]?.sources[0]?.node ?? '');

  async function add(addition: Addition): Promise<void> {
    const data = mapDataOf(node, input, session?.name ?? '');
    if (!connection || !session) return;
    const refuse = (text: string): void => session.setProblem(node.id, name, `${name}: ${text}`);
    if (!data) {
      refuse('connect the look with data first, then their middle is known');
      return;
    }
    try {
      const element = addition.of(await infoOf(connection, data));
      const path = [...node.path, name];
      const { document } = session.snapshot;
      const before = find(document, path);
      if (!find(document, node.path)) return; // The look was removed meanwhile.
      if (element === undefined) refuse('there are no data yet whose middle is known');
      else session.edit([{ set: path, to: [...(isList(before) ? before : []), element] }]);
    } catch (error) {
      refuse(messageOf(error));
    }
  }
  return (
    <div className="add-buttons" role="group" aria-label={`Add to ${name}`}>
      {additions.map((addition) => (
        <button
          key={addition.label}
          type="button"
          title={addition.help}
          aria-label={`${addition.help}, to ${name}`}
          onClick={() => void add(addition)}
        >
          {addition.label}
        </button>
      ))}
    </div>
  );
}
