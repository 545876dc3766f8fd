// SPDX-License-Identifier: Apache-2.0
// The operators of a view as its overlays see them, and what of them can be moved by hand.
import type { Path } from '../graph/edits';
import { find } from '../graph/edits';
import { isList, isObject, type Json, type JsonObject, member, textOf } from '../graph/json';
import { lookType } from '../graph/nodes';
import { isPlane, type Plane } from './plane';

export interface Look {
  /** Of the operator in the document. */
  readonly path: Path;
  /** Among the operators of the visualization. */
  readonly index: number;
  readonly entry: JsonObject;
  /** For people: its own name, else what it shows. */
  readonly name: string;
}

/** A slice or a clip plane. */
export interface PlaneOfLook {
  readonly look: Look;
  readonly kind: 'slice' | 'clip';
  /** Of the plane in the document. */
  readonly path: Path;
  readonly plane: Plane;
  /** For people: `slice 1`, and `slice 1 of balls`. */
  readonly name: string;
  readonly label: string;
}

export interface IsovalueOfLook {
  readonly look: Look;
  readonly path: Path;
  readonly value: number;
  readonly label: string;
}

/** A section may be one object or a list of them, under either of two names. */
function placesIn(document: Json, names: readonly string[]): { path: Path; entry: Json }[] {
  for (const name of names) {
    const value = member(document, name);
    if (isList(value)) return value.map((entry, i) => ({ path: [name, i], entry }));
    if (value !== undefined && value !== null) return [{ path: [name], entry: value }];
  }
  return [];
}

/** The operators of a visualization: its name in a graph, or its number. Those that are not there are left out. */
export function looksOf(document: JsonObject, which: string | number): readonly Look[] {
  const all = placesIn(document, ['Visualizations', 'Visualization']);
  const view =
    typeof which === 'number' ? all[which] : all.find(({ entry }) => textOf(entry, 'name') === which);
  const operators = view && member(view.entry, 'operators');
  if (!view || operators === undefined) return [];
  const list = isList(operators) ? operators : [operators];
  return list.flatMap((operator, index): Look[] => {
    const own = [...view.path, 'operators', ...(isList(operators) ? [index] : [])];
    const named =
      typeof operator === 'string'
        ? placesIn(document, ['Operators']).find(({ entry }) => textOf(entry, 'name') === operator)
        : { path: own, entry: operator };
    if (!named || !isObject(named.entry)) return [];
    const name = textOf(named.entry, 'name') || textOf(named.entry, 'dataset') || `operator ${index}`;
    return [{ path: named.path, index, entry: named.entry, name }];
  });
}

/** Of the look's node in the graph's canvas. */
export function idOf({ path, entry }: Look): string {
  const [section, name] = path;
  if (section === 'Operators') return `Operators/${String(entry['name'])}`;
  return `Inline/${String(name)}/${String(path[3])}`;
}

const isVolume = (look: Look): boolean => lookType(look.entry) === 'Volume';

export function planesOf(look: Look): readonly PlaneOfLook[] {
  const planeOf = (kind: 'slice' | 'clip', path: Path, plane: Plane, name: string): PlaneOfLook => ({
    ...{ look, kind, path, plane, name, label: `${name} of ${look.name}` },
  });
  const of = (key: string, kind: 'slice' | 'clip'): PlaneOfLook[] => {
    const value = member(look.entry, key);
    return (isList(value) ? value : []).flatMap((plane, i) =>
      isPlane(plane) ? [planeOf(kind, [...look.path, key, i], plane, `${kind} ${i + 1}`)] : [],
    );
  };
  const one = member(look.entry, 'plane');
  const single: PlaneOfLook[] = isPlane(one) ? [planeOf('slice', [...look.path, 'plane'], one, 'slice')] : [];
  return [...(isVolume(look) ? [...of('slices', 'slice'), ...single] : []), ...of('clip planes', 'clip')];
}

export function isovaluesOf(look: Look): readonly IsovalueOfLook[] {
  const values = isVolume(look) ? member(look.entry, 'isovalues') : undefined;
  return (isList(values) ? values : []).flatMap((value, i) =>
    typeof value === 'number'
      ? [{ look, path: [...look.path, 'isovalues', i], value, label: `isovalue ${i + 1} of ${look.name}` }]
      : [],
  );
}

/** The plane that a document has at a path now; undefined if it has none. */
export function planeAt(document: JsonObject, path: Path): Plane | undefined {
  const value = find(document, path);
  return isPlane(value) ? value : undefined;
}

/** Whether the operator shows colours by value. */
export function colorsByValue({ entry }: Look): boolean {
  if (lookType(entry) !== 'Volume') return true;
  const has = (key: string): boolean => {
    const value = member(entry, key);
    return isList(value) && value.length > 0;
  };
  return member(entry, 'volume rendering') === true || has('slices') || has('isovalues') || has('plane');
}

/** The looks whose legend and handles are shown: those that are selected, or all if none is. */
export function heldOf(looks: readonly Look[], selection: readonly string[]): readonly Look[] {
  const chosen = looks.filter((look) => selection.includes(idOf(look)));
  return chosen.length > 0 ? chosen : looks;
}
