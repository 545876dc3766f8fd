// SPDX-License-Identifier: Apache-2.0
import { type JsonObject, isObject, member, namesIn, textOf } from '../graph/json';

/** Datasets so that each stands behind those that it is made of, and else as they were. What is made of itself is not moved. */
export function inOrder(entries: readonly JsonObject[]): readonly JsonObject[] {
  const byName = new Map(entries.map((entry) => [textOf(entry, 'name'), entry]));
  const begun = new Set<JsonObject>();
  const ordered: JsonObject[] = [];
  const take = (entry: JsonObject): void => {
    if (begun.has(entry)) return;
    begun.add(entry);
    const inputs = member(entry, 'inputs');
    for (const value of isObject(inputs) ? Object.values(inputs) : [])
      for (const name of namesIn(value)) {
        const source = byName.get(name);
        if (source) take(source);
      }
    ordered.push(entry);
  };
  for (const entry of entries) take(entry);
  return ordered;
}
