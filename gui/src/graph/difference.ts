// SPDX-License-Identifier: Apache-2.0
// What has changed between two documents, where the edits between them are not known: the connection was lost meanwhile.
import type { Edit, Path } from './edits';
import { type Json, type JsonObject, equal, isList, isObject, member } from './json';

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
