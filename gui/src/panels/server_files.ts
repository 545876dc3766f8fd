// SPDX-License-Identifier: Apache-2.0
// Folders and files of the server, below its data folders (docs/protocol.md, `data.files`).
import type { Connection } from '../wire/connection';
import { isObject, type Json, type JsonObject, numberOf, objectsOf, textOf, textsOf } from '../wire/json';
import { statement } from '../wire/statement';

export interface ServerFile {
  readonly name: string;
  readonly bytes: number;
}

export interface Folder {
  readonly path: string; // relative to the data folders; empty: these themselves
  readonly folders: readonly string[];
  readonly files: readonly ServerFile[];
  /** There are more entries than the server lists. */
  readonly isCut: boolean;
}

export async function readFolder(connection: Connection, path: string): Promise<Folder> {
  const reply = await connection.request(statement('data.files', path === '' ? [] : [path]));
  return {
    path,
    folders: textsOf(reply, 'folders'),
    files: objectsOf(reply, 'files').map((f) => ({ name: textOf(f, 'name'), bytes: numberOf(f, 'bytes') })),
    isCut: reply['more'] === true,
  };
}

/** Files whose names differ in their last number only: the steps of a series. */
export interface FileGroup {
  /** Their names, as the server takes them together: `wave_%d.vti`. */
  readonly pattern: string;
  readonly files: readonly ServerFile[];
}

/** Files and series, in the order of their first files. */
export function grouped(files: readonly ServerFile[]): readonly (ServerFile | FileGroup)[] {
  const groups = new Map<string, ServerFile[]>();
  for (const file of files) {
    const [, before, after] = /^(.*?)\d+(\D*\.\D*)$/.exec(file.name) ?? [];
    const isNumbered = before !== undefined && after !== undefined && !/[%*?]/.test(file.name);
    const key = isNumbered ? `${before}%d${after}` : file.name;
    const group = groups.get(key) ?? [];
    groups.set(key, group);
    group.push(file);
  }
  return [...groups].flatMap(([pattern, group]): readonly (ServerFile | FileGroup)[] =>
    group.length < 2 ? group : [{ pattern, files: group }],
  );
}

export function inside(path: string, name: string): string {
  return path === '' ? name : `${path}/${name}`;
}

/** The folders on the way to a path, outermost first: what each is called, and its own path. */
export function wayTo(path: string): readonly (readonly [name: string, path: string])[] {
  const names = path.split('/').filter((name) => name !== '');
  return names.map((name, i) => [name, names.slice(0, i + 1).join('/')]);
}

/**
 * The state document of a file, with other names for its datasets where the server has other data of these names (`known`, of
 * `data.info`). Otherwise these would be shown in place of the file.
 */
export function withFreeNames(state: JsonObject, known: readonly JsonObject[]): JsonObject {
  const taken = new Set(known.map((d) => textOf(d, 'name')));
  const renamed = new Map<string, string>();
  for (const { name, filename } of objectsOf(state, 'Datasets')) {
    if (typeof name !== 'string' || !taken.has(name)) continue;
    if (known.some((d) => textOf(d, 'name') === name && textOf(d, 'file') === filename)) continue;
    let number = 2;
    while (taken.has(`${name} ${number}`)) number++;
    renamed.set(name, `${name} ${number}`);
    taken.add(`${name} ${number}`);
  }
  return withNames(state, renamed);
}

/** A state document whose datasets have other names. */
export function withNames(state: JsonObject, renamed: ReadonlyMap<string, string>): JsonObject {
  const changed = (json: Json | undefined, key: string): Json | undefined => {
    if (Array.isArray(json)) return json.map((item) => changed(item, key) ?? null);
    if (!isObject(json)) return json;
    const name = renamed.get(textOf(json, key));
    return name === undefined ? json : { ...json, [key]: name };
  };
  const looks = objectsOf(state, 'Visualizations').map((v) => ({
    ...v,
    operators: changed(v['operators'], 'dataset'),
  }));
  return { ...state, Datasets: changed(state['Datasets'], 'name'), Visualizations: looks };
}
