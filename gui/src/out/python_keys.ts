// SPDX-License-Identifier: Apache-2.0
// Keys of a document as arguments of the package gxy (python/src/gxy/catalogue.py), and the keys that its looks have by themselves.
import type { Catalogue, DataType, Property } from '../graph/catalogue';
import { equal, isList, type Json, type JsonObject, member } from '../graph/json';
import { defaultValue } from '../panels/values';
import { isIdentifier, KEYWORDS, literal, named, type Part } from './python_text';

/** What an entry says of known keys, by these keys, and all else that it says. */
export interface Keys {
  readonly known: ReadonlyMap<string, Json>;
  readonly others: readonly (readonly [key: string, value: Json])[];
}

// Arguments of the package's own.
const TAKEN = ['name', 'inputs'];

/** A key as Python can say it; undefined: it cannot, as an argument. */
export function argumentOf(key: string): string | undefined {
  const name = key.replace(/ /g, '_');
  if (KEYWORDS.has(name)) return `${name}_`;
  return isIdentifier(name) && !TAKEN.includes(name) ? name : undefined;
}

/** Sorts the members of an entry. Values that are the key's default are left out. */
export function keysOf(entry: JsonObject, properties: readonly Property[], without: readonly string[]): Keys {
  const known = new Map<string, Json>();
  const others: [string, Json][] = [];
  for (const [key, value] of Object.entries(entry)) {
    if (without.includes(key)) continue;
    const property = properties.find((p) => p.key === key || p.aliases.includes(key));
    const isTwice = property !== undefined && property.key !== key && Object.hasOwn(entry, property.key);
    if (!property || isTwice || argumentOf(property.key) === undefined) others.push([key, value]);
    else if (property.isRequired || !equal(value, defaultValue(property.defaultText)))
      known.set(property.key, value);
  }
  return { known, others };
}

export function argumentsOf(known: ReadonlyMap<string, Json>): Part[] {
  return [...known].map(([key, value]) => named(argumentOf(key) as string, literal(value)));
}

/** The keys that looks of a type have. */
export function lookProperties(catalogue: Catalogue, type: DataType): readonly Property[] {
  return (catalogue.sections.get('operator') ?? []).filter(
    ({ key, appliesTo }) =>
      !['type', 'dataset', 'key'].includes(key) && (appliesTo.length === 0 || appliesTo.includes(type)),
  );
}

const MAPS = ['colormap', 'transfer function', 'opacitymap', 'extinctionmap'];
const RADII = ['radius', 'radius0', 'radius1', 'value0', 'value1'];
const SHOWN = ['volume rendering', 'isovalues', 'slices', 'plane'];

/** What a look of gxy says that is made with these keys: Graph._look() of python/src/gxy/graph.py. */
function completed(type: DataType, said: ReadonlyMap<string, Json>): Map<string, Json> {
  const look = new Map(said);
  const hasAny = (keys: readonly string[]): boolean => keys.some((key) => look.has(key));
  if (type === 'Volume' && !hasAny(SHOWN)) look.set('volume rendering', true);
  if ((type === 'Particles' || type === 'PathLines') && !hasAny(RADII)) look.set('radius', 'auto');
  const hasMap = MAPS.some((key) => look.has(key) && typeof look.get(key) !== 'string');
  if (!look.has('data range') && !hasMap) {
    look.set('data range', 'data');
    if (look.get('volume rendering') === true)
      look.set('opacitymap', [
        [0, 0],
        [1, 0.1],
      ]);
  }
  return new Map([...look].filter(([, value]) => value !== null));
}

const asObject = (map: ReadonlyMap<string, Json>): JsonObject => Object.fromEntries(map);

/**
 * The arguments with which gxy makes a look that says this and no more. What it says by itself is not repeated, and what it would
 * say beyond this is None.
 */
export function lookArguments(type: DataType, said: ReadonlyMap<string, Json>): ReadonlyMap<string, Json> {
  let result = new Map(said);
  for (const own of [['volume rendering'], ['radius'], ['data range', 'opacitymap'], ['data range']]) {
    const fewer = new Map([...result].filter(([key]) => !own.includes(key)));
    if (equal(asObject(completed(type, fewer)), asObject(said))) result = fewer;
  }
  for (;;) {
    const beyond = [...completed(type, result).keys()].find((key) => !said.has(key));
    if (beyond === undefined) return result;
    result.set(beyond, null);
  }
}

/** The keys that views have, beside their looks and their name. */
export function viewProperties(catalogue: Catalogue): readonly Property[] {
  return (catalogue.sections.get('visualization') ?? []).filter(
    ({ key }) => !['operators', 'name'].includes(key),
  );
}

export const listOf = (value: Json | undefined): readonly Json[] =>
  value === undefined ? [] : isList(value) ? value : [value];

/** The rays of each pass of a picture of the document. */
export function raysOf(document: JsonObject): number {
  const rays = member(member(document, 'Renderer'), 'rays per pixel');
  return typeof rays === 'number' && rays > 0 ? rays : 1;
}
