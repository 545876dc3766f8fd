// SPDX-License-Identifier: Apache-2.0
// What a user does to a graph, as lists of edits.
import { type Edit, type Path, type Section, find } from './edits';
import { type Json, type JsonObject, isList, isObject, member, objectsIn, textOf } from './json';
import type { GraphEdge, GraphNode, NodeGraph, NodeInput } from './nodes';
import { idOf } from './nodes';

export type Position = readonly [x: number, y: number];

/** Sets a value at a path of keys, with the objects on the way that are not there yet. */
export function setDeep(document: Json, path: readonly string[], to: Json): Edit[] {
  for (let i = 1; i < path.length; i++)
    if (!isObject(find(document, path.slice(0, i)))) {
      const inner = path.slice(i).reduceRight<Json>((value, key) => ({ [key]: value }), to);
      return [{ set: path.slice(0, i), to: inner }];
    }
  return [{ set: path, to }];
}

export function positionOf(document: Json, id: string): Position | undefined {
  const at = find(document, ['GUI', 'nodes', id]);
  return isList(at) && typeof at[0] === 'number' && typeof at[1] === 'number' ? [at[0], at[1]] : undefined;
}

/** Puts nodes at places. */
export function moveNodes(document: JsonObject, positions: ReadonlyMap<string, Position>): Edit[] {
  if (positions.size === 0) return [];
  const moved = Object.fromEntries(
    [...positions].map(([id, [x, y]]): [string, Json] => [id, [Math.round(x), Math.round(y)]]),
  );
  const known = find(document, ['GUI', 'nodes']);
  // Each by itself, where it can be: then somebody else may move other nodes meanwhile.
  if (isObject(known) && positions.size <= 100)
    return Object.entries(moved).map(([id, to]) => ({ set: ['GUI', 'nodes', id], to }));
  return setDeep(document, ['GUI', 'nodes'], { ...(isObject(known) ? known : {}), ...moved });
}

export function namesOf(document: JsonObject, section: Section): readonly string[] {
  return objectsIn(member(document, section)).map((entry) => textOf(entry, 'name'));
}

/** `wanted`, or with the first number behind it that makes it free. */
export function freeName(taken: readonly string[], wanted: string): string {
  if (!taken.includes(wanted)) return wanted;
  const base = wanted.replace(/ \d+$/, '');
  for (let i = 2; ; i++) if (!taken.includes(`${base} ${i}`)) return `${base} ${i}`;
}

/** Adds an object with a free name to a section. Returns its id, too. */
export function addNode(
  document: JsonObject,
  section: Section,
  entry: JsonObject,
  at?: Position,
): { id: string; edits: Edit[] } {
  const name = freeName(namesOf(document, section), textOf(entry, 'name'));
  const id = idOf(section, name);
  const place = at ? moveNodes(document, new Map([[id, at]])) : [];
  return { id, edits: [{ add: [section], to: { ...entry, name } }, ...place] };
}

/** A name that an expression can use: letters, digits and `_`. */
function asIdentifier(name: string): string {
  const word = name
    .replace(/^.*[./]/, '')
    .replace(/[^A-Za-z0-9_]+/g, '_')
    .replace(/^_+|_+$/g, '');
  return /^[A-Za-z]/.test(word) ? word : `f${word}`;
}

/** Connects a node's output to an input of another. One that takes a single name is connected anew. */
export function connect(source: GraphNode, target: GraphNode, input: NodeInput): Edit[] {
  if (target.role === 'view') return [{ add: [...target.path, 'operators'], to: source.name }];
  if (target.role !== 'filter') return [{ set: [...target.path, input.name], to: source.name }];
  const inputs = member(target.entry, 'inputs');
  const given = isObject(inputs) ? inputs : {};
  let key = input.name;
  for (let i = 2, base = asIdentifier(source.name); key === ''; i++) {
    const wanted = i === 2 ? base : `${base}${i}`;
    if (member(given, wanted) === undefined) key = wanted;
  }
  const before = member(given, key);
  const to: Json =
    input.isMany && before !== undefined
      ? [...(isList(before) ? before : [before]), source.name]
      : source.name;
  return isObject(inputs)
    ? [{ set: [...target.path, 'inputs', key], to }]
    : [{ set: [...target.path, 'inputs'], to: { [key]: to } }];
}

/** A look that a view has without a name gets one, so that it can be connected to others. Returns the look as it then is. */
export function nameLook(document: JsonObject, node: GraphNode): { edits: Edit[]; node: GraphNode } {
  if (node.role !== 'look' || node.name !== '') return { edits: [], node };
  const name = freeName(namesOf(document, 'Operators'), `${textOf(node.entry, 'dataset') || 'data'} look`);
  const at = positionOf(document, node.id);
  const id = idOf('Operators', name);
  const edits: Edit[] = [
    { add: ['Operators'], to: { ...node.entry, name } },
    { set: node.path, to: name },
    ...(at ? moveNodes(document, new Map([[id, at]])) : []),
  ];
  return { edits, node: { ...node, id, name, path: ['Operators', name] } };
}

/** Takes one name out of an input. `index`: among the input's sources. */
export function disconnect(target: GraphNode, input: NodeInput, index: number): Edit[] {
  if (target.role === 'view') return [{ remove: [...target.path, 'operators', index] }];
  if (target.role !== 'filter') return [{ set: [...target.path, input.name], to: '' }];
  const path: Path = [...target.path, 'inputs', input.name];
  const rest = input.sources.filter((_, i) => i !== index).map((s) => s.name);
  return rest.length === 0
    ? [{ remove: path }]
    : [{ set: path, to: rest.length === 1 ? (rest[0] as string) : rest }];
}

export function disconnectEdge(graph: NodeGraph, edge: GraphEdge): Edit[] {
  const target = graph.byId.get(edge.target);
  const input = target?.inputs.find((i) => i.name === edge.input);
  return target && input ? disconnect(target, input, edge.index) : [];
}

/** Removes nodes and edges. What used a dataset keeps its name, so that it works again with another of that name. Views forget looks. */
export function removeAll(
  document: JsonObject,
  graph: NodeGraph,
  ids: readonly string[],
  edges: readonly GraphEdge[] = [],
): Edit[] {
  const nodes = ids.flatMap((id) => graph.byId.get(id) ?? []);
  const gone = new Set(ids);
  const looks = graph.edges.filter(
    (e) => gone.has(e.source) && !gone.has(e.target) && graph.byId.get(e.target)?.role === 'view',
  );
  // From behind, so that indices of lists stay those of the document. A look without a name goes with its edge.
  const cut = [...new Set([...edges.filter((e) => !gone.has(e.target)), ...looks])].sort(
    (a, b) => b.index - a.index,
  );
  const own = nodes
    .filter((n) => !isInline(n.id))
    .sort((a, b) => (Number(b.path[1]) || 0) - (Number(a.path[1]) || 0));
  return [
    ...cut.flatMap((edge) => disconnectEdge(graph, edge)),
    ...own.map((node): Edit => ({ remove: node.path })),
    ...forgetPositions(document, gone, cut),
  ];
}

export const isInline = (id: string): boolean => id.startsWith('Inline/');

/** Positions without those of nodes that go. Looks without names are known by their places in a view, which move up. */
function forgetPositions(document: JsonObject, gone: ReadonlySet<string>, cut: readonly GraphEdge[]): Edit[] {
  const known = find(document, ['GUI', 'nodes']);
  if (!isObject(known)) return [];
  const kept = Object.entries(known).flatMap(([id, at]): [string, Json][] => {
    const place = /^Inline\/(.*)\/(\d+)$/.exec(id);
    const lost = place ? cut.filter((e) => e.target === idOf('Visualizations', place[1] as string)) : [];
    if (gone.has(id) || lost.some((e) => e.index === Number(place?.[2]))) return [];
    const before = lost.filter((e) => e.index < Number(place?.[2])).length;
    return [[before > 0 && place ? `Inline/${place[1]}/${Number(place[2]) - before}` : id, at]];
  });
  const isSame =
    kept.length === Object.keys(known).length && kept.every(([id]) => member(known, id) !== undefined);
  return isSame ? [] : [{ set: ['GUI', 'nodes'], to: Object.fromEntries(kept) }];
}

export function rename(document: JsonObject, node: GraphNode, to: string): Edit[] {
  const named = nameLook(document, node);
  const section = named.node.path[0] as Section;
  const at = positionOf(document, node.id);
  const old = member(find(document, ['GUI', 'nodes']), node.id) !== undefined;
  return [
    ...(typeof named.node.path[1] === 'number'
      ? [{ set: [...named.node.path, 'name'], to } as Edit]
      : [...named.edits, { rename: [section, named.node.name], to } as Edit]),
    ...(old ? [{ remove: ['GUI', 'nodes', node.id] } as Edit] : []),
    ...(at ? [{ set: ['GUI', 'nodes', idOf(section, to)], to: at } as Edit] : []),
  ];
}

/** Those inputs of a node that a source fits, by `fits`. */
export function fittingInputs(node: GraphNode, fits: (input: NodeInput) => boolean): readonly NodeInput[] {
  return node.inputs.filter(fits);
}

/** Puts a filter into an edge: the edge's source goes to `input` of the filter, and the filter's output where the edge went. */
export function insertInto(graph: NodeGraph, edge: GraphEdge, node: GraphNode, input: NodeInput): Edit[] {
  const source = graph.byId.get(edge.source);
  const target = graph.byId.get(edge.target);
  const end = target?.inputs.find((i) => i.name === edge.input);
  if (!source || !target || !end) return [];
  return [...connect(source, node, input), ...replaceSource(target, end, edge.index, node.name)];
}

function replaceSource(target: GraphNode, input: NodeInput, index: number, name: string): Edit[] {
  if (target.role === 'view') return [{ set: [...target.path, 'operators', index], to: name }];
  if (target.role !== 'filter') return [{ set: [...target.path, input.name], to: name }];
  const names = input.sources.map((s, i) => (i === index ? name : s.name));
  return [
    { set: [...target.path, 'inputs', input.name], to: names.length === 1 ? (names[0] as string) : names },
  ];
}

/** Has what uses a filter use the filter's first input of the same type instead. No edits if it has none. */
export function bypass(graph: NodeGraph, node: GraphNode): Edit[] {
  const source = node.inputs
    .flatMap((i) => i.sources)
    .find((s) => s.node && graph.byId.get(s.node)?.gives === node.gives);
  if (!source) return [];
  return graph.edges
    .filter((edge) => edge.source === node.id)
    .flatMap((edge) => {
      const target = graph.byId.get(edge.target);
      const input = target?.inputs.find((i) => i.name === edge.input);
      return target && input ? replaceSource(target, input, edge.index, source.name) : [];
    });
}
