// SPDX-License-Identifier: Apache-2.0
// What the graph's parts of the page share: which graph is open, which nodes are selected, and what the server has to offer.
import { useSyncExternalStore } from 'react';
import { create } from 'zustand';
import { type Catalogue, DATA_TYPES, type DataType, EMPTY_CATALOGUE, catalogueOf } from '../graph/catalogue';
import { type Json, type JsonObject, member, objectsIn, textOf } from '../graph/json';
import { type LiveTypes, type NodeGraph, nodesOf } from '../graph/nodes';
import { type GraphSnapshot, GraphSession, messageOf } from '../graph/session';
import type { Connection } from '../wire/connection';
import type { JsonObject as WireObject } from '../wire/json';
import { statement } from '../wire/statement';

export interface GraphSummary {
  readonly name: string;
  readonly isReadOnly: boolean;
  readonly clients: number;
}

export interface LiveDataset {
  readonly name: string;
  readonly type: DataType | undefined;
  readonly typeText: string;
  readonly isShared: boolean;
  readonly generation: number;
}

interface GraphStore {
  readonly connection: Connection | undefined;
  readonly catalogue: Catalogue;
  readonly graphs: readonly GraphSummary[];
  readonly live: readonly LiveDataset[];
  readonly session: GraphSession | undefined;
  readonly selection: readonly string[];
  /** The node that the canvas is to bring into sight. */
  readonly sought: string | undefined;
  /** The last thing that could not be done, for people. */
  readonly message: string;
  setLive: (live: readonly LiveDataset[]) => void;
  select: (ids: readonly string[]) => void;
  seek: (id: string | undefined) => void;
  say: (message: string) => void;
}

export const useGraphStore = create<GraphStore>((set) => ({
  connection: undefined,
  catalogue: EMPTY_CATALOGUE,
  graphs: [],
  live: [],
  session: undefined,
  selection: [],
  sought: undefined,
  message: '',
  setLive: (live) => set({ live }),
  select: (selection) => set({ selection }),
  seek: (sought) => set({ sought }),
  say: (message) => set({ message }),
}));

const { setState, getState } = useGraphStore;

export const dataTypeOf = (text: string): DataType | undefined => DATA_TYPES.find((type) => type === text);

export async function refreshGraphs(): Promise<readonly GraphSummary[]> {
  const { connection } = getState();
  if (connection?.state.kind !== 'open') return [];
  const reply = (await connection.request('graph.list')) as Json;
  const graphs = objectsIn(member(reply, 'graphs')).map((g) => ({
    name: textOf(g, 'graph'),
    isReadOnly: member(g, 'read only') === true,
    clients: Number(member(g, 'clients') ?? 0),
  }));
  setState({ graphs });
  return graphs;
}

/** Begins with a connection: asks for the catalogue and the graphs at each time that it is open. Returns what ends that. */
export function beginGraphs(connection: Connection): () => void {
  setState({ connection });
  const ask = (): void => {
    if (connection.state.kind !== 'open') return;
    Promise.all([connection.request('graph.types'), refreshGraphs()]).then(
      ([types]) => setState({ catalogue: catalogueOf(types as Json) }),
      (error: unknown) => getState().say(messageOf(error)),
    );
  };
  ask();
  return connection.onState(ask);
}

export function openGraph(name: string): void {
  const { connection, session } = getState();
  if (!connection || session?.name === name) return;
  session?.close();
  setState({ session: new GraphSession(connection, name), selection: [] });
}

export function closeGraph(): void {
  getState().session?.close();
  setState({ session: undefined, selection: [] });
}

/** Makes a graph of a document, or an empty one, and opens it. Throws the server's Error if it refuses. */
export async function newGraph(name: string, document: WireObject = {}): Promise<void> {
  const { connection } = getState();
  if (!connection) return;
  const { warnings } = await connection.request(statement('graph.new', [name], document));
  await refreshGraphs();
  openGraph(name);
  for (const warning of (warnings ?? []) as string[]) getState().session?.note(warning);
}

/** The document of a graph: of the one that is open with the edits that are not sent yet. Throws the server's Error. */
export async function graphDocument(name: string): Promise<Json> {
  const { connection, session } = getState();
  if (session?.name === name && session.snapshot.isLoaded) return session.snapshot.document;
  if (!connection) throw new Error('the server is not connected');
  return member((await connection.request(statement('graph.get', [name]))) as Json, 'document') ?? {};
}

export async function dropGraph(name: string): Promise<void> {
  const { connection, session } = getState();
  if (!connection) return;
  if (session?.name === name) closeGraph();
  await connection.request(statement('graph.drop', [name]));
  await refreshGraphs();
}

const NO_SNAPSHOT = (): undefined => undefined;
const NEVER = (): (() => void) => () => undefined;

export function useSnapshot(): GraphSnapshot | undefined {
  const session = useGraphStore((s) => s.session);
  return useSyncExternalStore<GraphSnapshot | undefined>(
    session?.subscribe ?? NEVER,
    session ? () => session.snapshot : NO_SNAPSHOT,
  );
}

export function liveTypes(live: readonly LiveDataset[]): LiveTypes {
  return new Map(live.flatMap((d): [string, DataType][] => (d.type ? [[d.name, d.type]] : [])));
}

const NO_NODES: NodeGraph = { nodes: [], byId: new Map(), edges: [] };

let newest: { readonly from: readonly unknown[]; readonly graph: NodeGraph } | undefined;

/** Components that ask for the nodes of one document get the same object, which is made once. */
function nodeGraph(document: JsonObject, catalogue: Catalogue, live: readonly LiveDataset[]): NodeGraph {
  const from = [document, catalogue, live];
  if (!newest || from.some((part, i) => part !== newest?.from[i]))
    newest = { from, graph: nodesOf(document, catalogue, liveTypes(live)) };
  return newest.graph;
}

/** The nodes of the graph that is open. */
export function useNodeGraph(): NodeGraph {
  const document = useSnapshot()?.document;
  const catalogue = useGraphStore((s) => s.catalogue);
  const live = useGraphStore((s) => s.live);
  return document ? nodeGraph(document, catalogue, live) : NO_NODES;
}
