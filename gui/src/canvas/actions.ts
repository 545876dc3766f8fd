// SPDX-License-Identifier: Apache-2.0
// What the canvas, its menus and its keys do to the graph that is open.
import {
  type Position,
  addNode,
  bypass,
  connect,
  disconnectEdge,
  insertInto,
  moveNodes,
  nameLook,
  namesOf,
  positionOf,
  removeAll,
  rename,
} from '../graph/changes';
import { type Edit, type Section, applied, find } from '../graph/edits';
import { fragmentIn, fragmentOf, paste } from '../graph/fragment';
import {
  type Json,
  type JsonObject,
  isList,
  isObject,
  member,
  objectsIn,
  textOf,
  withoutMember,
} from '../graph/json';
import {
  type GraphEdge,
  type GraphNode,
  type NodeGraph,
  type NodeInput,
  edgeProblem,
  idOf,
  nodesOf,
} from '../graph/nodes';
import { type GraphSession, messageOf, VIEW_ONLY } from '../graph/session';
import type { View } from '../view/view';
import { useViews } from '../view/views';
import type { ServerConnection } from '../app/server_connection';
import { openSeries } from '../steps/series_store';
import { statement } from '../wire/statement';
import type { AddItem } from './add_items';
import { firstLook } from './add_items';
import { dataTypeOf, liveTypes, useGraphStore } from './graph_store';
import { COLUMN, heightOf, placesFor } from './layout';
import { type Rect, type Size, placeBelow, placeWithRoom } from './room';

const store = useGraphStore.getState;

/** Edits that are made one after the other, each list of what the document is by then, and one step for undo. */
export class Change {
  readonly edits: Edit[] = [];
  constructor(public document: JsonObject) {}

  get graph(): NodeGraph {
    return graphOf(this.document);
  }
  add(edits: readonly Edit[]): this {
    if (edits.length > 0) this.document = applied(this.document, edits).document;
    this.edits.push(...edits);
    return this;
  }
}

function graphOf(document: JsonObject): NodeGraph {
  return nodesOf(document, store().catalogue, liveTypes(store().live));
}

function change(): Change | undefined {
  const { session } = store();
  return session?.snapshot.isLoaded ? new Change(session.snapshot.document) : undefined;
}

/** Sends a change, and selects the nodes that it made. */
function make(change_: Change, selected?: readonly string[]): void {
  const { session, select, say } = store();
  if (session?.snapshot.isViewOnly) say(VIEW_ONLY);
  if (session?.edit(change_.edits) && selected) select(selected);
}

/** Connects an output to an input, or says why that cannot be. */
export function connectNodes(
  sourceId: string,
  targetId: string,
  inputName: string,
  without?: GraphEdge,
): void {
  const edit = change();
  if (!edit) return;
  if (without) edit.add(disconnectEdge(edit.graph, without));
  const problem = addConnection(edit, sourceId, targetId, (i) => i.name === inputName);
  if (problem !== '') store().say(problem);
  else make(edit);
}

function addConnection(
  edit: Change,
  sourceId: string,
  targetId: string,
  which: (input: NodeInput) => boolean,
): string {
  const source = edit.graph.byId.get(sourceId);
  if (!source) return 'The node is gone.';
  const named = nameLook(edit.document, source);
  edit.add(named.edits);
  const { graph } = edit;
  const target = graph.byId.get(targetId);
  const from = graph.byId.get(named.node.id);
  const input = target?.inputs.find(which);
  if (!from || !target || !input) return 'The node is gone.';
  const problem = edgeProblem(graph, from, target, input);
  if (problem === '') edit.add(connect(from, target, input));
  return problem;
}

export interface AddPlace {
  readonly at: Position;
  /** The new node takes this output, */
  readonly source?: string;
  /** or gives this input its data. */
  readonly target?: { readonly id: string; readonly input: string };
}

/** How large the cards of the canvas are, as far as they were drawn. */
export const cardSizes = new Map<string, Size>();

const WIDTH = 190; // of a card

const TEXT = 90; // of what a card says is missing, at most

function sizeOf(node: GraphNode): Size {
  const isMissing = node.inputs.some((i) => !i.isOptional && !i.isAnyName && i.sources.length === 0);
  const height = heightOf(node) + (isMissing ? TEXT : 0);
  return cardSizes.get(node.id) ?? { width: WIDTH, height };
}

/** The cards of a graph as the canvas places them. */
function rectsOf({ document, graph }: Change): Map<string, Rect> {
  const known = new Map(
    graph.nodes.flatMap((n): [string, Position][] => {
      const at = positionOf(document, n.id);
      return at ? [[n.id, at]] : [];
    }),
  );
  const free = placesFor(graph, known);
  return new Map(
    graph.nodes.map((node): [string, Rect] => {
      const [x, y] = known.get(node.id) ?? free.get(node.id) ?? [0, 0];
      return [node.id, { x, y, ...sizeOf(node) }];
    }),
  );
}

/** Adds a node where it has room. Returns its id. */
function addAt(edit: Change, section: Section, entry: JsonObject, at: Position): string {
  const others = [...rectsOf(edit).values()];
  const { id, edits } = addNode(edit.document, section, entry);
  const node = edit.add(edits).graph.byId.get(id);
  if (node) edit.add(moveNodes(edit.document, new Map([[id, placeWithRoom(at, sizeOf(node), others)]])));
  return id;
}

/** Right of what the new node reads, or left of what reads it. */
function beside(edit: Change, { at: [x, y], source, target }: AddPlace): Position {
  const rects = rectsOf(edit);
  const [from, to] = [rects.get(source ?? ''), rects.get(target?.id ?? '')];
  if (from) return [Math.max(x, from.x + COLUMN), y];
  return to ? [Math.min(x, to.x - COLUMN), y] : [x, y];
}

/** Joins a new look to the view, if the graph has exactly one and the look is not in it. */
function joinToOnlyView(edit: Change, id: string): void {
  const { graph } = edit;
  const [view, another] = graph.nodes.filter((n) => n.role === 'view');
  const [look, input] = [graph.byId.get(id), view?.inputs[0]];
  if (!view || another || !input || look?.role !== 'look') return;
  if (input.sources.some((s) => s.node === id) || !isList(member(view.entry, 'operators'))) return;
  edit.add(connect(look, view, input));
}

/** Adds a node, connected as the place says, and selects it. Returns its id. */
export function addItem(item: AddItem, place: AddPlace): string {
  const edit = change();
  if (!edit) return '';
  const id = addAt(edit, item.section, item.entry, beside(edit, place));
  const { source, target } = place;
  const from = source === undefined ? undefined : edit.graph.byId.get(source);
  if (from)
    addConnection(
      edit,
      from.id,
      id,
      (i) => edgeProblem(edit.graph, from, edit.graph.byId.get(id) as GraphNode, i) === '',
    );
  if (target) {
    const problem = addConnection(edit, id, target.id, (i) => i.name === target.input);
    if (problem !== '') store().say(problem);
  }
  joinToOnlyView(edit, id);
  make(edit, [id]);
  return id;
}

export function removeSelected(nodes: readonly string[], edges: readonly GraphEdge[]): void {
  const edit = change();
  if (!edit || nodes.length + edges.length === 0) return;
  make(edit.add(removeAll(edit.document, edit.graph, nodes, edges)), []);
}

/** Gives a node another name. A window on a view that is renamed shows it under its new name. */
export function renameNode(id: string, to: string): void {
  const edit = change();
  const node = edit?.graph.byId.get(id);
  if (!edit || !node || to === '' || to === node.name) return;
  try {
    edit.add(rename(edit.document, node, to));
  } catch (error) {
    store().session?.setProblem(id, 'name', messageOf(error));
    return;
  }
  const wasOpen = node.role === 'view' && closeView(node.name);
  make(edit, [
    idOf(
      edit.edits.length > 0 && node.id.startsWith('Inline/') ? 'Operators' : (node.path[0] as 'Datasets'),
      to,
    ),
  ]);
  if (wasOpen) openView(to);
}

export function move(positions: ReadonlyMap<string, Position>, gesture = ''): void {
  const edit = change();
  if (edit && positions.size > 0)
    store().session?.edit(moveNodes(edit.document, positions), gesture === '' ? {} : { gesture });
}

export function bypassNode(id: string): void {
  const edit = change();
  const node = edit?.graph.byId.get(id);
  if (!edit || !node) return;
  const edits = bypass(edit.graph, node);
  if (edits.length === 0)
    store().say(
      `${node.name || 'This node'} cannot be bypassed: nothing uses it, or it has no input of its type.`,
    );
  else make(edit.add(edits));
}

/** Puts a node that is not connected into an edge on which it was dropped. */
export function insertNode(id: string, edgeId: string, at: Position): boolean {
  const edit = change();
  if (!edit) return false;
  const { graph } = edit;
  const node = graph.byId.get(id);
  const edge = graph.edges.find((e) => e.id === edgeId);
  const source = edge && graph.byId.get(edge.source);
  const end = edge && graph.byId.get(edge.target)?.inputs.find((i) => i.name === edge.input);
  const isFree = !graph.edges.some((e) => e.source === id || e.target === id);
  const input =
    node && source && isFree
      ? node.inputs.find((i) => edgeProblem(graph, source, node, i) === '')
      : undefined;
  if (!node || !edge || !end || !input || (node.gives !== undefined && !end.takes.includes(node.gives)))
    return false;
  make(edit.add(insertInto(graph, edge, node, input)).add(moveNodes(edit.document, new Map([[id, at]]))));
  return true;
}

/** The state file of the selected nodes, as text; empty if none are. */
export function copied(ids: readonly string[]): string {
  const edit = change();
  const nodes = ids.flatMap((id) => edit?.graph.byId.get(id) ?? []);
  return edit && nodes.length > 0 ? `${JSON.stringify(fragmentOf(edit.document, nodes), null, 2)}\n` : '';
}

/** Adds the nodes of a state file's text. Returns false if it is none. */
export function pasted(text: string, offset: Position = [40, 40]): boolean {
  const fragment = fragmentIn(text);
  const edit = change();
  if (!fragment || !edit) return false;
  const { edits, ids } = paste(edit.document, fragment, offset);
  make(edit.add(edits), ids);
  return true;
}

/** Gives the focus to a node's card, once it is drawn. */
export function focusCard(id: string): void {
  setTimeout(() => {
    const cards = document.querySelectorAll<HTMLElement>('.react-flow__node');
    [...cards].find((card) => card.dataset['id'] === id)?.focus({ preventScroll: true });
  }, 50);
}

const titleFor = (graph: string, view: string): string => `${graph} / ${view}`;

/** Shows a view of the graph that is open in the view area. */
export function openView(name: string): void {
  const { session, connection, say } = store();
  if (!session || !connection) return;
  const title = titleFor(session.name, name);
  const { views, add, activate } = useViews.getState();
  const known = views.find((view) => view.title === title);
  if (known) {
    holdWithGraph(known, session, name);
    activate(known.id);
    return;
  }
  // The page's connection brings pixels, too.
  const view = add(title, { kind: 'graph', graph: session.name, view: name }, connection as ServerConnection);
  view.onNotice = say;
  holdWithGraph(view, session, name);
  // The view's camera is what its user sees. Undo leaves it: whoever turns the picture back turns it.
  view.onRest = (camera) => {
    const { session: now } = store();
    if (now?.name !== session.name || !now.snapshot.isLoaded || now.snapshot.isViewOnly) return;
    if (find(now.snapshot.document, ['Visualizations', name]))
      now.edit([{ set: ['Visualizations', name, 'camera'], to: camera as JsonObject }], {
        history: 'none',
      });
  };
}

/** A view is held by the graph (`follow` of its document), so all who look at it see one step, from any side. */
function holdWithGraph(view: View, session: GraphSession, name: string): void {
  const path = ['Visualizations', name, 'follow'];
  const look = (): void => {
    const { document, isViewOnly } = session.snapshot;
    view.whyNotHeld = isViewOnly
      ? VIEW_ONLY
      : session !== store().session
        ? `Open graph ${session.name} to hold its views.`
        : '';
    view.showHeld(find(document, path) === false);
  };
  look();
  followed.get(view)?.();
  followed.set(view, session.subscribe(look));
  view.onHold = (held) => {
    if (session.snapshot.isLoaded && find(session.snapshot.document, path.slice(0, 2)))
      session.edit([held ? { set: path, to: false } : { remove: path }], { history: 'none' });
  };
}

const followed = new WeakMap<View, () => void>(); // what ends a view's listening to its graph

export function closeView(name: string): boolean {
  const graph = store().session?.name ?? '';
  const { views, close } = useViews.getState();
  const known = views.find((view) => view.title === titleFor(graph, name));
  if (known) close(known.id);
  return known !== undefined;
}

/** Adds a dataset of the server with a look that suits it, and shows both in a view: the selected one, the first, or a new one. */
export async function showDataset(name: string, at?: Position): Promise<void> {
  const { connection, say } = store();
  if (!connection) return;
  try {
    const reply = (await connection.request(statement('viewer.scene', [name]))) as Json;
    const edit = change();
    if (!edit) return;
    const scene = member(reply, 'state') ?? {};
    const type = objectsIn(member(scene, 'Datasets')).find((d) => textOf(d, 'name') === name);
    const known = store().live.find((d) => d.name === name);
    const entry = { name, type: known?.type ?? dataTypeOf(textOf(type, 'type')) ?? 'Volume' };
    const place = at ?? below(edit);
    if (!edit.graph.byId.has(idOf('Datasets', name))) addAt(edit, 'Datasets', entry, place);
    finishScene(edit, [addLook(edit, { entry, shown: name }, scene, place)]);
  } catch (error) {
    say(messageOf(error));
  }
}

const below = (edit: Change): Position => placeBelow([...rectsOf(edit).values()]);

/**
 * Adds the datasets of a file of the server as nodes that read it, with looks that suit them, and shows them in a view. Those of a series are
 * data of the server, whatever step they are.
 */
export async function showFile(path: string): Promise<void> {
  const { connection, say } = store();
  if (!connection) return;
  try {
    if (!change()) return;
    const answer = await connection.request(statement('viewer.scene', [path]));
    const opened = await openSeries(connection, path, answer);
    const edit = change();
    if (!edit) return;
    const scene = (opened?.document ?? member(answer as Json, 'state') ?? {}) as Json;
    const looks = objectsIn(member(scene, 'Datasets')).map((entry) => {
      const place = below(edit);
      const id = addAt(edit, 'Datasets', entry, place);
      return addLook(edit, { entry, shown: id.slice('Datasets/'.length) }, scene, place);
    });
    finishScene(edit, looks);
  } catch (error) {
    say(messageOf(error));
  }
}

/** Adds the look that a scene proposes for a dataset, which the graph calls `shown`, to a view. Returns the look's id and the view. */
function addLook(
  edit: Change,
  { entry, shown }: { entry: JsonObject; shown: string },
  scene: Json,
  [x, y]: Position,
): { id: string; view: string } {
  const name = textOf(entry, 'name');
  const visualization = member(scene, 'Visualization') ?? objectsIn(member(scene, 'Visualizations'))[0] ?? {};
  const proposed = objectsIn(member(visualization, 'operators')).find((o) => textOf(o, 'dataset') === name);
  const look: JsonObject = {
    ...(proposed ?? firstLook(textOf(entry, 'type'))),
    dataset: shown,
    name: `${shown} look`,
  };
  const id = addAt(edit, 'Operators', look, [x + COLUMN, y]);
  const views = edit.graph.nodes.filter((n) => n.role === 'view');
  const view = views.find((v) => store().selection.includes(v.id)) ?? views[0];
  const lookName = id.slice('Operators/'.length);
  if (view) {
    edit.add([{ add: [...view.path, 'operators'], to: lookName }]);
    return { id, view: view.name };
  }
  const camera = member(scene, 'Camera') ?? objectsIn(member(scene, 'Cameras'))[0] ?? { fit: true };
  const base = isObject(visualization) ? withoutMember(visualization, 'operators') : {};
  const made = { ...base, name: 'view', operators: [lookName], camera };
  addAt(edit, 'Visualizations', made, [x + 2 * COLUMN, y]);
  return { id, view: namesOf(edit.document, 'Visualizations')[0] as string };
}

function finishScene(edit: Change, looks: readonly { id: string; view: string }[]): void {
  make(
    edit,
    looks.map(({ id }) => id),
  );
  if (looks[0]) openView(looks[0].view);
}
