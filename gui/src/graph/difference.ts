// SPDX-License-Identifier: Apache-2.0
// What has changed between two documents, where the edits between them are not known: the connection was lost meanwhile.
import { type Edit, type Path, applied, find } from './edits';
import { type Json, type JsonObject, equal, isList, isObject, member } from './json';
import { pathOf } from './undo';

const nameOf = (item: Json): string | undefined => {
  const name = member(item, 'name');
  return typeof name === 'string' && name !== '' ? name : undefined;
};

/** The names of a list whose elements all have one of their own; else undefined. */
function namesOf(list: readonly Json[]): readonly string[] | undefined {
  const names = list.map(nameOf);
  const isNamed = names.every((name) => name !== undefined) && new Set(names).size === names.length;
  return isNamed ? (names as readonly string[]) : undefined;
}

/** Edits that make one document of the other. Elements of lists are the same if their names are. */
export function difference(from: JsonObject, to: JsonObject, path: Path = []): readonly Edit[] {
  const gone = Object.keys(from).filter((key) => !Object.hasOwn(to, key));
  const edits: Edit[] = gone.map((key) => ({ remove: [...path, key] }));
  for (const [key, value] of Object.entries(to))
    edits.push(...between(member(from, key), value, [...path, key]));
  return edits;
}

function between(from: Json | undefined, to: Json, path: Path): readonly Edit[] {
  if (equal(from, to)) return [];
  if (isObject(from) && isObject(to)) return difference(from, to, path);
  return (isList(from) && isList(to) && betweenLists(from, to, path)) || [{ set: path, to }];
}

/** Undefined: the lists differ by more than elements that came, went or changed. */
function betweenLists(from: readonly Json[], to: readonly Json[], path: Path): readonly Edit[] | undefined {
  const [before, after] = [namesOf(from), namesOf(to)];
  if (!before || !after) return undefined;
  const isSame = (order: readonly string[], other: readonly string[]): boolean =>
    equal(
      order.filter((name) => after.includes(name)),
      other.filter((name) => before.includes(name)),
    );
  if (!isSame(before, after)) return undefined;
  const edits: Edit[] = before
    .filter((name) => !after.includes(name))
    .map((name) => ({ remove: [...path, name] }));
  to.forEach((item, at) => {
    const name = after[at] as string;
    const place = before.indexOf(name);
    if (place < 0) edits.push({ add: path, to: item, at });
    else edits.push(...between(from[place], item, [...path, name]));
  });
  return edits;
}

/**
 * Whether the server has carried out own edits that it did not reply to, by what its document is now. `missed` is by how much its revision
 * is ahead of that of `before`. Of one edit that was missed it is certain. Of several, the document has the edits if it has anything that
 * they do and `before` lacks: an edit is carried out whole or not at all. Where that is an error, since others did the same, the edit is
 * left out; it is never carried out twice.
 */
export function wasOrdered(
  before: JsonObject,
  now: JsonObject,
  missed: number,
  edits: readonly Edit[],
): boolean {
  let guess: JsonObject;
  try {
    guess = applied(before, edits).document;
  } catch {
    return false;
  }
  if (missed === 0 || equal(before, now)) return false;
  if (missed === 1) return equal(guess, now);
  return edits.some((edit) => isDone(edit, before, guess, now));
}

/** Whether the document has now what an edit does, and had not before. */
function isDone(edit: Edit, before: JsonObject, guess: JsonObject, now: JsonObject): boolean {
  if ('rename' in edit) {
    const renamed: Path = [edit.rename[0] as string, edit.to];
    return find(before, renamed) === undefined && find(now, renamed) !== undefined;
  }
  if ('set' in edit) {
    const is = (document: JsonObject): boolean => equal(find(document, edit.set), edit.to);
    return is(now) && !is(before);
  }
  const path = pathOf(edit);
  const list = 'add' in edit ? path : path.slice(0, -1);
  if (!isList(find(guess, list))) return find(now, path) === undefined && find(before, path) !== undefined;
  // Elements with a name are there once; of others only their number tells.
  const item = 'add' in edit ? edit.to : find(before, path);
  const count = (document: JsonObject): number => countIn(find(document, list), item);
  return 'add' in edit ? count(now) > count(before) : count(now) < count(before);
}

function countIn(list: Json | undefined, item: Json | undefined): number {
  const name = item === undefined ? undefined : nameOf(item);
  const isIt = (other: Json): boolean => (name === undefined ? equal(other, item) : nameOf(other) === name);
  return isList(list) ? list.filter(isIt).length : 0;
}
