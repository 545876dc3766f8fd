// SPDX-License-Identifier: Apache-2.0
// The edits of docs/graph.md, applied as the server applies them (multiserver/graph/document_edits.cpp), with the edits that undo them.
import {
  type Json,
  type JsonObject,
  isList,
  isObject,
  member,
  quoted,
  withMember,
  withoutMember,
} from './json';

export type Step = string | number;
export type Path = readonly Step[];
export type Edit =
  | { readonly set: Path; readonly to: Json }
  | { readonly add: Path; readonly to: Json; readonly at?: number }
  | { readonly remove: Path }
  | { readonly rename: Path; readonly to: string };

export interface Edited {
  readonly document: JsonObject;
  readonly inverse: readonly Edit[];
}

/** What an edit asks for and the document does not allow. The text names the path and what was expected. */
export class EditError extends Error {}

/** A path as messages call it: `Datasets["seeds"].count`. */
export function pathText(path: Path): string {
  let text = '';
  path.forEach((step, i) => {
    text += typeof step === 'string' && i !== 1 ? (i === 0 ? '' : '.') + step : `[${JSON.stringify(step)}]`;
  });
  return text || 'document';
}

/** The place of a list's element, by its index or its name; undefined if there is none. */
export function placeIn(list: readonly Json[], step: Step | undefined): number | undefined {
  if (typeof step === 'number')
    return Number.isInteger(step) && step >= 0 && step < list.length ? step : undefined;
  const place = list.findIndex((item) => isObject(item) && member(item, 'name') === step);
  return place < 0 ? undefined : place;
}

function child(value: Json, path: Path, i: number): Json {
  const step = path[i];
  if (isObject(value) && typeof step === 'string') {
    const found = member(value, step);
    if (found === undefined) throw new EditError(`${pathText(path.slice(0, i + 1))}: there is none`);
    return found;
  }
  if (isList(value)) {
    const place = placeIn(value, step);
    if (place === undefined)
      throw new EditError(`${pathText(path.slice(0, i + 1))}: there is no such element`);
    return value[place] as Json;
  }
  throw new EditError(
    `${pathText(path.slice(0, i + 1))}: expected a key of an object or an element of a list, found ${quoted(step)}`,
  );
}

/** The value at a path. Throws EditError where the path leads nowhere. */
export function valueAt(document: Json, path: Path): Json {
  return path.reduce<Json>((value, _, i) => child(value, path, i), document);
}

/** The value at a path; undefined where the path leads nowhere. */
export function find(document: Json, path: Path): Json | undefined {
  let value: Json | undefined = document;
  for (const step of path) {
    const place: number | undefined = isList(value) ? placeIn(value, step) : undefined;
    if (isList(value)) value = place === undefined ? undefined : value[place];
    else value = typeof step === 'string' ? member(value, step) : undefined;
  }
  return value;
}

/** The value with another one at `path`, whose last step must be there or be a new key of an object. */
function replaced(value: Json, path: Path, to: Json, i = 0): Json {
  if (i === path.length) return to;
  const step = path[i] as Step;
  if (isObject(value) && typeof step === 'string') {
    const isNew = i === path.length - 1;
    return withMember(value, step, isNew ? to : replaced(child(value, path, i), path, to, i + 1));
  }
  const inner = replaced(child(value, path, i), path, to, i + 1);
  const list = value as readonly Json[];
  return list.map((item, k) => (k === placeIn(list, step) ? inner : item));
}

interface State {
  document: JsonObject;
  inverse: Edit[]; // in the order of the edits
  isWhole: boolean; // only the whole document of before undoes the edits
}

function applySet(state: State, path: Path, to: Json): void {
  if (path.length === 0) {
    if (!isObject(to)) throw new EditError(`set: the document is an object, found ${quoted(to)}`);
    state.isWhole = true;
    state.document = to;
    return;
  }
  const last = path[path.length - 1] as Step;
  const parent = valueAt(state.document, path.slice(0, -1));
  if (isObject(parent) && typeof last === 'string') {
    const old = member(parent, last);
    state.inverse.push(old === undefined ? { remove: path } : { set: path, to: old });
  } else {
    const old = valueAt(state.document, path);
    // The inverse says the place, since the element may get another name.
    const place = placeIn(parent as readonly Json[], last) as number;
    state.inverse.push({ set: [...path.slice(0, -1), place], to: old });
  }
  state.document = replaced(state.document, path, to) as JsonObject;
}

function applyAdd(state: State, path: Path, to: Json, at: number | undefined): void {
  if (path.length === 0) throw new EditError('add: expected the path of a list, found []');
  const last = path[path.length - 1] as Step;
  const parent = valueAt(state.document, path.slice(0, -1));
  const isNew = isObject(parent) && typeof last === 'string' && member(parent, last) === undefined;
  const list = isNew ? [] : valueAt(state.document, path);
  if (!isList(list)) throw new EditError(`${pathText(path)}: expected a list, found ${quoted(list)}`);
  const place = at ?? list.length;
  if (!Number.isInteger(place) || place < 0 || place > list.length)
    throw new EditError(`${pathText(path)}: \`at\`: expected 0 to ${list.length}, found ${quoted(place)}`);
  state.inverse.push({ remove: isNew ? path : [...path, place] });
  state.document = replaced(state.document, path, [
    ...list.slice(0, place),
    to,
    ...list.slice(place),
  ]) as JsonObject;
}

function applyRemove(state: State, path: Path): void {
  if (path.length === 0) throw new EditError('remove: expected the path of a member or an element, found []');
  const value = valueAt(state.document, path);
  const last = path[path.length - 1] as Step;
  const above = path.slice(0, -1);
  const parent = valueAt(state.document, above);
  if (isObject(parent)) {
    state.inverse.push({ set: path, to: value });
    state.document = replaced(state.document, above, withoutMember(parent, last as string)) as JsonObject;
    return;
  }
  const list = parent as readonly Json[];
  const place = placeIn(list, last) as number;
  state.inverse.push({ add: above, to: value, at: place });
  state.document = replaced(
    state.document,
    above,
    list.filter((_, i) => i !== place),
  ) as JsonObject;
}

export const SECTIONS = ['Datasets', 'Operators', 'Visualizations', 'Outputs'] as const;
export type Section = (typeof SECTIONS)[number];

/** The document with each name that refers to an element of a section given to `change`. */
export function withReferences(
  document: JsonObject,
  section: string,
  change: (name: string) => string,
): JsonObject {
  const name = (value: Json): Json => (typeof value === 'string' ? change(value) : value);
  const names = (value: Json): Json => (isList(value) ? value.map(name) : name(value));
  const at =
    (key: string, with_: (value: Json) => Json) =>
    (object: Json): Json => {
      const value = member(object, key);
      return value === undefined ? object : withMember(object as JsonObject, key, with_(value));
    };
  const all =
    (change_: (item: Json) => Json) =>
    (value: Json): Json =>
      isList(value) ? value.map((item) => (isObject(item) ? change_(item) : item)) : value;
  const inputs = at('inputs', (value) =>
    isObject(value) ? Object.fromEntries(Object.entries(value).map(([k, v]) => [k, names(v)])) : value,
  );
  let out: Json = document;
  if (section === 'Datasets') {
    out = at('Datasets', all(inputs))(out);
    out = at('Operators', all(at('dataset', name)))(out);
    out = at('Visualizations', all(at('operators', all(at('dataset', name)))))(out);
  }
  if (section === 'Operators') out = at('Visualizations', all(at('operators', names)))(out);
  if (section === 'Datasets' || section === 'Visualizations') out = at('Outputs', all(at('of', name)))(out);
  return out as JsonObject;
}

function refersTo(document: JsonObject, section: string, wanted: string): boolean {
  let found = false;
  withReferences(document, section, (name) => {
    found ||= name === wanted;
    return name;
  });
  return found;
}

function applyRename(state: State, path: Path, to: string): void {
  const section = path[0];
  if (path.length !== 2 || !SECTIONS.some((s) => s === section))
    throw new EditError(
      `rename: expected ["Datasets", "Operators", "Visualizations" or "Outputs", ELEMENT], found ${quoted(path)}`,
    );
  if (typeof to !== 'string' || to === '')
    throw new EditError(`${pathText(path)}: \`to\`: expected a name, found ${quoted(to)}`);
  const element = valueAt(state.document, path);
  const from = member(element, 'name');
  if (typeof from !== 'string')
    throw new EditError(`${pathText(path)}: it has no name; expected an element with one`);
  if (from === to) return;
  const list = valueAt(state.document, [section as string]) as readonly Json[];
  if (placeIn(list, to) !== undefined)
    throw new EditError(`${pathText(path)}: the name "${to}" is in use, expected a free one`);
  // Names that would be taken for those that are changed here cannot be told apart later.
  if (refersTo(state.document, section as string, to)) state.isWhole = true;
  else state.inverse.push({ rename: [section as string, to], to: from });
  const renamed = replaced(state.document, [...path, 'name'], to) as JsonObject;
  state.document = withReferences(renamed, section as string, (name) => (name === from ? to : name));
}

function applyOne(state: State, edit: Edit): void {
  if ('set' in edit) applySet(state, edit.set, edit.to);
  else if ('add' in edit) applyAdd(state, edit.add, edit.to, edit.at);
  else if ('remove' in edit) applyRemove(state, edit.remove);
  else applyRename(state, edit.rename, edit.to);
}

/** Sections that may be one object become lists, and their short names the long ones, as the server makes them. */
export function normalised(document: JsonObject): JsonObject {
  let out = document;
  for (const [key, alias] of [
    ['Datasets', ''],
    ['Operators', ''],
    ['Visualizations', 'Visualization'],
    ['Cameras', 'Camera'],
    ['Outputs', ''],
  ] as const) {
    const short = alias === '' ? undefined : member(out, alias);
    if (short !== undefined && member(out, key) === undefined)
      out = withMember(withoutMember(out, alias), key, short);
    const value = member(out, key);
    if (value !== undefined && !isList(value)) out = withMember(out, key, [value]);
  }
  return out;
}

/** Applies a list of edits, all or none. Throws EditError, with the number of the edit, where one cannot be applied. */
export function applied(document: JsonObject, edits: readonly Edit[]): Edited {
  const state: State = { document, inverse: [], isWhole: false };
  edits.forEach((edit, i) => {
    try {
      applyOne(state, edit);
    } catch (error) {
      if (error instanceof EditError) throw new EditError(`edit: \`edits\`[${i}]: ${error.message}`);
      throw error;
    }
  });
  const inverse: readonly Edit[] = state.isWhole ? [{ set: [], to: document }] : state.inverse.reverse();
  return { document: normalised(state.document), inverse };
}
