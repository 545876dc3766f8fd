// SPDX-License-Identifier: Apache-2.0
// The nodes and edges of a document. Datasets, looks (operators), views (visualizations with names) and outputs are its nodes. Its edges
// are the names that they use of each other, so an edge is never kept apart from the node that it leads to.
import { type Catalogue, DATA_TYPES, type DataType, type InputPort, type PortType } from './catalogue';
import type { Path, Section } from './edits';
import { type Json, type JsonObject, isList, isObject, member, namesIn, objectsIn, textOf } from './json';

export type Role = 'live' | 'file' | 'filter' | 'look' | 'view' | 'output';

export interface GraphNode {
  /** `SECTION/NAME`. A look that a view has without a name: `Inline/VIEW/INDEX`. */
  readonly id: string;
  readonly role: Role;
  readonly name: string; // empty: a look without one
  readonly path: Path; // of its object in the document
  readonly entry: JsonObject;
  readonly inputs: readonly NodeInput[];
  readonly gives: PortType | undefined; // undefined: nothing, or its type is not known
  readonly hasOutput: boolean;
  /** False: this server has no such filter, or no such type of look. */
  readonly isKnown: boolean;
}

export interface NodeInput extends InputPort {
  /** What it is connected to: ids of nodes, or undefined where the document has no such name. */
  readonly sources: readonly { readonly name: string; readonly node: string | undefined }[];
}

export interface GraphEdge {
  readonly id: string;
  readonly source: string;
  readonly target: string;
  readonly input: string;
  readonly index: number; // among the input's sources
  readonly type: PortType | undefined;
}

export interface NodeGraph {
  readonly nodes: readonly GraphNode[];
  readonly byId: ReadonlyMap<string, GraphNode>;
  readonly edges: readonly GraphEdge[];
}

export const idOf = (section: Section, name: string): string => `${section}/${name}`;

/** The type of each live dataset of the data space, where it is known. */
export type LiveTypes = ReadonlyMap<string, DataType>;

const dataType = (text: string): DataType | undefined => DATA_TYPES.find((type) => type === text);

/** The type of a look: `VolumeVis` is `Volume`, `Surface` means Triangles. */
export function lookType(entry: Json): DataType | undefined {
  const text = textOf(entry, 'type').replace(/Vis$/, '');
  return dataType(text === 'Surface' ? 'Triangles' : text);
}

/** What of an output is: a view of pictures, else a dataset. */
export const ofTypes = (entry: Json): readonly PortType[] =>
  textOf(entry, 'type') === 'Pictures' ? ['View'] : DATA_TYPES;

class Reading {
  private readonly datasets: ReadonlyMap<string, JsonObject>;
  private readonly types = new Map<string, DataType | undefined>();
  private readonly named = new Map<Section, ReadonlySet<string>>();
  readonly nodes: GraphNode[] = [];

  constructor(
    private readonly document: JsonObject,
    private readonly catalogue: Catalogue,
    private readonly live: LiveTypes,
  ) {
    this.datasets = new Map(this.entries('Datasets').map(({ entry, name }) => [name, entry]));
  }

  read(): void {
    for (const e of this.entries('Datasets')) this.nodes.push(this.dataset(e.entry, e.name));
    for (const e of this.entries('Operators'))
      this.nodes.push(this.look(e.entry, e.name, idOf('Operators', e.name), ['Operators', e.name]));
    for (const e of this.entries('Visualizations')) this.view(e.entry, e.name);
    for (const e of this.entries('Outputs')) this.nodes.push(this.output(e.entry, e.name, e.path));
  }

  private entries(section: Section): { entry: JsonObject; name: string; path: Path }[] {
    return objectsIn(member(this.document, section)).flatMap(
      (entry, i): { entry: JsonObject; name: string; path: Path }[] => {
        const name = textOf(entry, 'name');
        if (name !== '') return [{ entry, name, path: [section, name] }];
        const to = section === 'Outputs' ? textOf(entry, 'to') : ''; // what the server calls it then
        return to === '' ? [] : [{ entry, name: to, path: [section, i] }];
      },
    );
  }

  /** The type of a dataset; undefined if it is not known. A dataset that is made of itself has none. */
  private typeOf(name: string, seen: readonly string[] = []): DataType | undefined {
    if (this.types.has(name)) return this.types.get(name);
    const entry = this.datasets.get(name);
    if (!entry || seen.includes(name)) return undefined;
    const filter = this.catalogue.filters.get(textOf(entry, 'filter'));
    let type = dataType(textOf(entry, 'type')) ?? filter?.makes;
    if (filter?.makesLike) {
      const source = namesIn(member(member(entry, 'inputs'), filter.makesLike))[0];
      type = source === undefined ? undefined : this.typeOf(source, [...seen, name]);
    } else if (textOf(entry, 'filter') === '') type ??= this.live.get(name);
    this.types.set(name, type);
    return type;
  }

  private namesOf(section: Section): ReadonlySet<string> {
    const names = this.named.get(section) ?? new Set(this.entries(section).map((e) => e.name));
    this.named.set(section, names);
    return names;
  }

  private sources(section: Section, names: readonly string[]): NodeInput['sources'] {
    const known = this.namesOf(section);
    return names.map((name) => ({ name, node: known.has(name) ? idOf(section, name) : undefined }));
  }

  private dataset(entry: JsonObject, name: string): GraphNode {
    const type = textOf(entry, 'filter');
    const filter = this.catalogue.filters.get(type);
    const role = type !== '' ? 'filter' : textOf(entry, 'filename') !== '' ? 'file' : 'live';
    return {
      id: idOf('Datasets', name),
      role,
      name,
      path: ['Datasets', name],
      entry,
      inputs: role === 'filter' ? this.filterInputs(entry, filter?.inputs ?? []) : [],
      gives: this.typeOf(name),
      hasOutput: role !== 'filter' || !filter || filter.makes !== undefined || filter.makesLike !== '',
      isKnown: role !== 'filter' || filter !== undefined,
    };
  }

  private filterInputs(entry: JsonObject, ports: readonly InputPort[]): NodeInput[] {
    const inputs = member(entry, 'inputs');
    const given = isObject(inputs) ? inputs : {};
    const fixed = ports.filter((p) => !p.isAnyName);
    const free = ports.find((p) => p.isAnyName);
    const others = Object.keys(given).filter((key) => !fixed.some((p) => p.name === key));
    const any: InputPort = {
      name: '',
      takes: DATA_TYPES,
      takesText: 'data',
      isOptional: true,
      isMany: false,
      isAnyName: true,
      help: '',
    };
    const of = (port: InputPort, key: string): NodeInput => ({
      ...port,
      name: key,
      sources: this.sources('Datasets', namesIn(member(given, key))),
    });
    return [
      ...fixed.map((port) => of(port, port.name)),
      ...others.map((key) => of(free ?? any, key)),
      ...(free ? [{ ...free, name: '', sources: [] }] : []), // an input that the next edge makes
    ];
  }

  private look(entry: JsonObject, name: string, id: string, path: Path): GraphNode {
    const type = lookType(entry);
    const input: NodeInput = {
      name: 'dataset',
      takes: type ? [type] : DATA_TYPES,
      takesText: type ?? 'data',
      isOptional: false,
      isMany: false,
      isAnyName: false,
      help: 'The data that are shown.',
      sources: this.sources('Datasets', namesIn(member(entry, 'dataset'))),
    };
    return {
      id,
      role: 'look',
      name,
      path,
      entry,
      inputs: [input],
      gives: 'Look',
      hasOutput: true,
      isKnown: type !== undefined,
    };
  }

  private view(entry: JsonObject, name: string): void {
    const operators = member(entry, 'operators');
    const known = this.namesOf('Operators');
    const sources = (isList(operators) ? operators : []).map((operator, i) => {
      if (typeof operator === 'string')
        return { name: operator, node: known.has(operator) ? idOf('Operators', operator) : undefined };
      const id = `Inline/${name}/${i}`;
      if (!isObject(operator)) return { name: `operator ${i}`, node: undefined };
      this.nodes.push(this.look(operator, '', id, ['Visualizations', name, 'operators', i]));
      return { name: '', node: id };
    });
    const input: NodeInput = {
      name: 'operators',
      takes: ['Look'],
      takesText: 'looks',
      isOptional: true,
      isMany: true,
      isAnyName: false,
      help: 'What the picture shows.',
      sources,
    };
    this.nodes.push({
      id: idOf('Visualizations', name),
      role: 'view',
      name,
      path: ['Visualizations', name],
      entry,
      inputs: [input],
      gives: 'View',
      hasOutput: true,
      isKnown: true,
    });
  }

  private output(entry: JsonObject, name: string, path: Path): GraphNode {
    const takes = ofTypes(entry);
    const input: NodeInput = {
      name: 'of',
      takes,
      takesText: takes[0] === 'View' ? 'a view' : 'data',
      isOptional: false,
      isMany: false,
      isAnyName: false,
      help: 'What it is made of.',
      sources: this.sources(
        takes[0] === 'View' ? 'Visualizations' : 'Datasets',
        namesIn(member(entry, 'of')),
      ),
    };
    const isKnown = ['Pictures', 'Data file', 'Publish'].includes(textOf(entry, 'type'));
    return {
      id: idOf('Outputs', name),
      role: 'output',
      name,
      path,
      entry,
      inputs: [input],
      gives: undefined,
      hasOutput: false,
      isKnown,
    };
  }
}

/** Reads the nodes and edges of a document. `live`: the types of datasets of the data space. */
export function nodesOf(document: JsonObject, catalogue: Catalogue, live: LiveTypes): NodeGraph {
  const reading = new Reading(document, catalogue, live);
  reading.read();
  const byId = new Map(reading.nodes.map((node) => [node.id, node]));
  const edges = reading.nodes.flatMap((target) =>
    target.inputs.flatMap((input) =>
      input.sources.flatMap((source, index): GraphEdge[] => {
        if (source.node === undefined) return [];
        const id = `${source.node} > ${target.id} ${input.name} ${index}`;
        const type = byId.get(source.node)?.gives;
        return [{ id, source: source.node, target: target.id, input: input.name, index, type }];
      }),
    ),
  );
  return { nodes: reading.nodes, byId, edges };
}

/** Why an output cannot go into an input; empty if it can. Both types are named. A type that is not known fits, and the server decides. */
export function misfit(source: GraphNode, target: GraphNode, input: InputPort): string {
  if (source.id === target.id) return 'A node cannot be its own input.';
  if (!source.hasOutput) return `${source.name} makes no data.`;
  if (source.gives === undefined && input.takes.some((type) => DATA_TYPES.some((t) => t === type))) return '';
  if (source.gives !== undefined && input.takes.includes(source.gives)) return '';
  const name = input.name === '' ? 'a new input' : input.name;
  return `${source.name || 'This look'} gives ${source.gives ?? 'data'}, and ${name} of ${target.name || 'this look'} takes ${input.takesText}.`;
}

/** The nodes that a node is made of, directly or by others. */
export function ancestors(graph: NodeGraph, id: string): ReadonlySet<string> {
  const found = new Set<string>();
  const open = [id];
  for (let next = open.pop(); next !== undefined; next = open.pop())
    for (const edge of graph.edges)
      if (edge.target === next && !found.has(edge.source)) {
        found.add(edge.source);
        open.push(edge.source);
      }
  return found;
}

/** What speaks against an edge; empty if nothing does. */
export function edgeProblem(
  graph: NodeGraph,
  source: GraphNode,
  target: GraphNode,
  input: InputPort,
): string {
  const wrong = misfit(source, target, input);
  if (wrong !== '') return wrong;
  return ancestors(graph, source.id).has(target.id)
    ? `${source.name} is made of ${target.name}: an edge back would be a cycle.`
    : '';
}
