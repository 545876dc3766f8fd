// SPDX-License-Identifier: Apache-2.0
// What nodes there are, and what may be said of them: what `graph.types` tells. Forms, ports and the add menu are made of it, so a new
// filter of the server needs nothing here.
import { type Json, member, objectsIn, textOf } from './json';
import { type ValueType, valueType } from './value_type';

export const DATA_TYPES = ['Volume', 'Particles', 'PathLines', 'Triangles'] as const;
export type DataType = (typeof DATA_TYPES)[number];
/** What goes through an edge. Looks go to views, and views to outputs. */
export type PortType = DataType | 'Look' | 'View';

export interface InputPort {
  readonly name: string;
  readonly takes: readonly PortType[];
  readonly takesText: string; // in words
  readonly isOptional: boolean;
  readonly isMany: boolean;
  /** Entries choose the names of such inputs, and have any number of them. */
  readonly isAnyName: boolean;
  readonly help: string;
}

export interface Property {
  readonly key: string;
  readonly aliases: readonly string[];
  readonly type: ValueType;
  readonly typeText: string;
  readonly defaultText: string;
  readonly isRequired: boolean;
  readonly isAdvanced: boolean;
  readonly help: string;
  /** The types to which it applies; empty: all. */
  readonly appliesTo: readonly string[];
  /** A flag without which it has no effect; empty: none. */
  readonly needs: string;
}

export interface FilterType {
  readonly name: string;
  readonly help: string;
  readonly inputs: readonly InputPort[];
  readonly properties: readonly Property[];
  /** Undefined: it tells numbers and makes no dataset, or its type is that of the input `makesLike`. */
  readonly makes: DataType | undefined;
  readonly makesLike: string;
}

export interface Catalogue {
  readonly filters: ReadonlyMap<string, FilterType>;
  /** The keys of the objects of a state file, by what docs/state-file.md calls these: `operator`, `camera`, ... */
  readonly sections: ReadonlyMap<string, readonly Property[]>;
}

export const EMPTY_CATALOGUE: Catalogue = { filters: new Map(), sections: new Map() };

function typesIn(text: string): readonly DataType[] {
  return DATA_TYPES.filter((type) => new RegExp(`\\b${type}\\b`).test(text));
}

function inputOf(json: Json): InputPort {
  const takesText = textOf(json, 'takes');
  return {
    name: textOf(json, 'name'),
    takes: typesIn(takesText),
    takesText,
    isOptional: member(json, 'optional') === true,
    isMany: member(json, 'many') === true,
    isAnyName: member(json, 'any name') === true,
    help: textOf(json, 'help'),
  };
}

function propertyOf(json: Json): Property {
  const list = (key: string): readonly string[] => {
    const value = member(json, key);
    return Array.isArray(value) ? value.filter((item) => typeof item === 'string') : [];
  };
  const typeText = textOf(json, 'type');
  return {
    key: textOf(json, 'key'),
    aliases: list('aliases'),
    type: valueType(typeText),
    typeText,
    defaultText: textOf(json, 'default'),
    isRequired: member(json, 'required') === true,
    isAdvanced: member(json, 'advanced') === true,
    help: textOf(json, 'help'),
    appliesTo: list('types'),
    needs: textOf(json, 'needs'),
  };
}

function filterOf(json: Json): FilterType {
  const makes = textOf(json, 'makes');
  return {
    name: textOf(json, 'name'),
    help: textOf(json, 'help'),
    inputs: objectsIn(member(json, 'inputs')).map(inputOf),
    properties: objectsIn(member(json, 'properties')).map(propertyOf),
    makes: DATA_TYPES.find((type) => type === makes),
    makesLike: /^what `(.+)` is$/.exec(makes)?.[1] ?? '',
  };
}

/** Reads the reply of `graph.types`. */
export function catalogueOf(reply: Json): Catalogue {
  return {
    filters: new Map(
      objectsIn(member(reply, 'filters'))
        .map(filterOf)
        .map((f) => [f.name, f]),
    ),
    sections: new Map(
      objectsIn(member(reply, 'sections')).map((s) => [
        textOf(s, 'section'),
        objectsIn(member(s, 'keys')).map(propertyOf),
      ]),
    ),
  };
}

/** Text of the server's help as plain text: without the marks of Markdown. */
export function plainText(help: string): string {
  return help
    .replace(/\[([^\]]*)\]\([^)]*\.md[^)]*\)/g, '$1')
    .replace(/`([^`]*)`/g, '$1')
    .replace(/\\([*_])/g, '$1');
}

const GROUPS: readonly (readonly [string, readonly string[]])[] = [
  ['Sample', ['Seeds', 'Sampler']],
  ['Trace', ['Tracer', 'Lines']],
];

/** The group of the add menu that a filter is in. */
export function groupOf(filter: FilterType): string {
  if (!filter.makes && filter.makesLike === '') return 'Measure';
  return GROUPS.find(([, endings]) => endings.some((end) => filter.name.endsWith(end)))?.[0] ?? 'Derive';
}
