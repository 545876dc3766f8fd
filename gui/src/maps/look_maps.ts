// SPDX-License-Identifier: Apache-2.0
// The maps of a look: what its entry in the document says, and the edits that say it otherwise.
//
// Where the look has a `data range`, the server stretches each map so that its ends lie on the range's. The editor shows and writes all
// points where they lie then, in the unit of the data. Maps that are written so are not changed by stretching.
import type { Catalogue } from '../graph/catalogue';
import type { Edit } from '../graph/edits';
import { type Json, isList, member } from '../graph/json';
import { type GraphNode, lookType } from '../graph/nodes';
import { defaultValue } from '../panels/values';
import { type ShippedMap, shippedMap } from './colormaps';
import { type Points, type Span, between } from './points';

export type MapKind = 'color' | 'opacity';

export interface LookMap {
  readonly kind: MapKind;
  readonly key: string; // of the entry
  /** The name that the entry says in place of points; empty: none. */
  readonly name: string;
  /** Where they lie in the data. Undefined: they are in a file of the server. */
  readonly points: Points | undefined;
}

/** `own`: the maps' own values. `data`: what the data have. Else numbers. */
export type RangeKind = 'own' | 'data' | 'numbers';

export interface LookMaps {
  readonly color: LookMap;
  /** Undefined: the look has no opacity by value. */
  readonly opacity: LookMap | undefined;
  readonly isExtinction: boolean;
  readonly rangeKind: RangeKind;
  /** On which the ends of the maps lie and stay; undefined: they are free. */
  readonly range: Span | undefined;
}

function isPoints(value: Json | undefined, size: number): boolean {
  return (
    isList(value) &&
    value.length > 0 &&
    value.every(
      (p) => isList(p) && p.length === size && p.every((x) => typeof x === 'number' && Number.isFinite(x)),
    )
  );
}

const pointsIn = (value: Json | undefined, size: number): Points | undefined =>
  isPoints(value, size)
    ? [...(value as unknown as Points)].sort((a, b) => a[0] - b[0]) // as the server sorts them
    : undefined;

export function spanIn(value: Json | undefined): Span | undefined {
  if (!isList(value) || value.length !== 2) return undefined;
  const [low, high] = value;
  return typeof low === 'number' && typeof high === 'number' && low <= high ? [low, high] : undefined;
}

/** Parts of a range that is not known yet. */
const UNKNOWN: Span = [0, 1];

/** The points that a look without a key has: what the server says of the key. */
function defaultPoints(catalogue: Catalogue, key: string, size: number): Points | undefined {
  const property = catalogue.sections.get('operator')?.find((p) => p.key === key);
  return property && pointsIn(defaultValue(property.defaultText), size);
}

/** Reads them. `dataRange`: what the look's data have, where that is known. */
export function lookMapsOf(
  node: GraphNode,
  catalogue: Catalogue,
  shipped: readonly ShippedMap[],
  dataRange: Span | undefined,
): LookMaps {
  const { entry } = node;
  const said = member(entry, 'data range');
  const numbers = spanIn(said);
  const rangeKind = said === 'data' ? 'data' : numbers ? 'numbers' : 'own';
  const range = rangeKind === 'data' ? (dataRange ?? UNKNOWN) : numbers;
  const shown = (own: Points | undefined): Points | undefined => own && (range ? between(own, range) : own);

  const key = ['colormap', 'transfer function'].find((k) => member(entry, k) !== undefined) ?? 'colormap';
  const color = member(entry, key);
  const text = typeof color === 'string' && color !== '' && color !== 'default' ? color : '';
  const colors =
    text === ''
      ? (pointsIn(color, 4) ?? defaultPoints(catalogue, 'colormap', 4))
      : shippedMap(shipped, text)?.colors;
  const isExtinction = member(entry, 'extinctionmap') !== undefined;
  const opacityKey = isExtinction ? 'extinctionmap' : 'opacitymap';
  const opacities = pointsIn(member(entry, opacityKey), 2) ?? defaultPoints(catalogue, 'opacitymap', 2);
  const hasOpacity = lookType(entry) === 'Volume' && member(entry, 'volume rendering') === true;
  return {
    color: { kind: 'color', key, name: text, points: shown(colors) },
    opacity: hasOpacity
      ? { kind: 'opacity', key: opacityKey, name: '', points: shown(opacities) }
      : undefined,
    isExtinction,
    rangeKind,
    range,
  };
}

const json = (points: Points): Json => points as unknown as Json;

export function setPoints(node: GraphNode, map: LookMap, points: Points): Edit {
  return { set: [...node.path, map.key], to: json(points) };
}

export function setKey(node: GraphNode, key: string, to: Json | undefined): readonly Edit[] {
  if (to !== undefined) return [{ set: [...node.path, key], to }];
  return member(node.entry, key) === undefined ? [] : [{ remove: [...node.path, key] }];
}

/** Another range. Without one, points that the entry says stay where they are now. */
export function setRange(node: GraphNode, maps: LookMaps, to: Span | 'data' | undefined): readonly Edit[] {
  const kept = to === undefined && maps.range !== undefined;
  const stay = [maps.color, maps.opacity].flatMap((map): Edit[] =>
    kept && map?.points && map.name === '' && member(node.entry, map.key) !== undefined
      ? [setPoints(node, map, map.points)]
      : [],
  );
  return [...stay, ...setKey(node, 'data range', to as unknown as Json | undefined)];
}
