// SPDX-License-Identifier: Apache-2.0
// The colour maps that the server ships.
import type { Connection } from '../wire/connection';
import { objectsOf, textOf } from '../wire/json';

export interface ShippedMap {
  readonly name: string;
  /** [value, r, g, b] of 0 to 1, ascending by value. */
  readonly colors: readonly (readonly [number, number, number, number])[];
}

const kept = new WeakMap<Connection, Promise<readonly ShippedMap[]>>();

/** Asks for them once in a connection's life. */
export async function shippedMaps(connection: Connection): Promise<readonly ShippedMap[]> {
  const asked =
    kept.get(connection) ??
    connection.request('viewer.colormaps').then((reply) =>
      objectsOf(reply, 'maps').map((map) => ({
        name: textOf(map, 'name'),
        colors: map['colors'] as unknown as ShippedMap['colors'],
      })),
    );
  kept.set(connection, asked);
  asked.catch(() => kept.delete(connection)); // It is asked again where it was not answered.
  return asked;
}

const folded = (name: string): string =>
  name
    .replace(/\s/g, '')
    .toLowerCase()
    .replace(/^grey$/, 'gray');

/** The shipped map that a document calls so. Letter case and blanks do not matter. */
export function shippedMap(maps: readonly ShippedMap[], name: string): ShippedMap | undefined {
  return maps.find((map) => folded(map.name) === folded(name));
}
