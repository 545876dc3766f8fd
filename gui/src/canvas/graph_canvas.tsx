// SPDX-License-Identifier: Apache-2.0
// The canvas: nodes and edges of the graph that is open, and what mouse and keys do there.
import {
  Background,
  type Connection as FlowConnection,
  ConnectionLineType,
  Controls,
  type Edge,
  type EdgeChange,
  type FinalConnectionState,
  type NodeChange,
  type OnConnectStartParams,
  ReactFlow,
  ReactFlowProvider,
  applyEdgeChanges,
  applyNodeChanges,
  useReactFlow,
} from '@xyflow/react';
import '@xyflow/react/dist/base.css';
import {
  type ClipboardEvent,
  type DragEvent,
  type MouseEvent as ReactMouseEvent,
  useCallback,
  useMemo,
  useRef,
  useState,
} from 'react';
import { type Position, positionOf } from '../graph/changes';
import { type GraphEdge, type GraphNode, type NodeGraph, edgeProblem } from '../graph/nodes';
import { type GraphSnapshot, VIEW_ONLY } from '../graph/session';
import {
  addItem,
  cardSizes,
  connectNodes,
  copied,
  focusCard,
  insertNode,
  move,
  openView,
  pasted,
  showDataset,
  type AddPlace,
} from './actions';
import { addItems, fits, matching, type Fitting } from './add_items';
import { DATASET } from '../panels/data_list';
import './canvas.css';
import { useNodeGraph, useSnapshot, useGraphStore } from './graph_store';
import { onCanvasKey, portOf } from './keys';
import { arranged, placesFor } from './layout';
import { Menu } from './menu';
import { withWords } from './menu_item';
import { beginDragging, endDragging } from './fitting_ports';
import { type CardData, type CardNode, NodeCard } from './node_card';
import { portItems } from './ports_menu';
import { INPUT, OUTPUT, kindOf, titleOf } from './titles';
import { FIT, useSight } from './use_sight';
import { useStable } from './use_stable';

const TYPES = { card: NodeCard };

interface Opened {
  readonly x: number; // of the canvas, in pixels
  readonly y: number;
  readonly place?: AddPlace; // the add menu
  readonly port?: { readonly id: string; readonly name: string }; // the list of a port
}

/** Cards of the graph; those that say the same as before are the same objects, so that only what has changed is drawn again. */
function cardsOf(
  graph: NodeGraph,
  snapshot: GraphSnapshot,
  before: readonly CardNode[],
  selection: readonly string[],
): CardNode[] {
  const known = new Map(
    graph.nodes.flatMap((n): [string, Position][] => {
      const at = positionOf(snapshot.document, n.id);
      return at ? [[n.id, at]] : [];
    }),
  );
  const free = placesFor(graph, known);
  const old = new Map(before.map((card) => [card.id, card]));
  const chosen = new Set(selection);
  return graph.nodes.map((node) => {
    const last = old.get(node.id);
    const state = snapshot.states.get(node.id);
    const problems = snapshot.problems.filter((p) => p.node === node.id);
    const [x, y] = known.get(node.id) ?? free.get(node.id) ?? [0, 0];
    const data = last && isSame(last.data, { node, state, problems }) ? last.data : { node, state, problems };
    return {
      ...(last ?? {}),
      ...{ id: node.id, type: 'card' as const, data, selected: chosen.has(node.id) },
      position: last?.dragging ? last.position : { x, y },
      ariaLabel: `${titleOf(node)}, ${kindOf(node)}${state ? `, ${state.kind}` : ''}`,
    };
  });
}

function isSame(a: CardData, b: CardData): boolean {
  const ports = ({ inputs, gives, isKnown }: GraphNode): string => JSON.stringify([inputs, gives, isKnown]);
  const isSameNode = a.node === b.node || (a.node.entry === b.node.entry && ports(a.node) === ports(b.node));
  return isSameNode && a.state === b.state && JSON.stringify(a.problems) === JSON.stringify(b.problems);
}

function edgesOf(graph: NodeGraph, before: readonly Edge[]): Edge[] {
  const chosen = new Set(before.filter((e) => e.selected).map((e) => e.id));
  const name = (id: string): string => {
    const node = graph.byId.get(id);
    return node ? titleOf(node) : id;
  };
  return graph.edges.map((edge) => ({
    ...{
      id: edge.id,
      source: edge.source,
      target: edge.target,
      sourceHandle: OUTPUT,
      targetHandle: INPUT + edge.input,
    },
    ...{ selected: chosen.has(edge.id), className: `edge-${edge.type ?? 'any'}` },
    ariaLabel: `Edge from ${name(edge.source)} to ${edge.input || 'input'} of ${name(edge.target)}`,
  }));
}

const MULTI_SELECTION = ['Control', 'Meta', 'Shift'];

function Canvas() {
  const graph = useNodeGraph();
  const snapshot = useSnapshot();
  const { session, catalogue, live, selection, select, say, message } = useGraphStore();
  const flow = useReactFlow<CardNode>();
  const [cards, setCards] = useState<CardNode[]>([]);
  const [edges, setEdges] = useState<Edge[]>([]);
  const [opened, setOpened] = useState<Opened>();
  const place = useRef<HTMLDivElement>(null);
  const focused = useRef<HTMLElement | null>(null); // before a menu was opened
  const byMouse = useRef(false); // the canvas has the focus by a click
  const sight = useSight(session, graph, selection);
  const items = useMemo(() => addItems(catalogue, live), [catalogue, live]);

  // What the canvas shows follows the graph, but for nodes that are being dragged: React's pattern for state of props.
  const [followed, setFollowed] = useState<readonly unknown[]>([]);
  if (snapshot && [graph, snapshot, selection].some((part, i) => part !== followed[i])) {
    setFollowed([graph, snapshot, selection]);
    setCards(cardsOf(graph, snapshot, cards, selection));
    if (graph !== followed[0]) setEdges(edgesOf(graph, edges));
  }

  const isLoaded = snapshot?.isLoaded === true;
  const inside = useCallback((x: number, y: number) => {
    const box = place.current?.getBoundingClientRect();
    return { x: x - (box?.left ?? 0), y: y - (box?.top ?? 0) };
  }, []);

  function open(at: { x: number; y: number }, more: Omit<Opened, 'x' | 'y'>): void {
    if (snapshot?.isViewOnly) {
      say(VIEW_ONLY);
      return;
    }
    focused.current = document.activeElement as HTMLElement | null;
    say('');
    setOpened({ ...at, ...more });
  }
  function close(): void {
    setOpened(undefined);
    if (focused.current?.isConnected) focused.current.focus({ preventScroll: true });
    else place.current?.focus({ preventScroll: true });
  }

  function openAdd(x: number, y: number, more: Partial<AddPlace> = {}): void {
    const at = flow.screenToFlowPosition({ x, y });
    open(inside(x, y), { place: { at: [at.x, at.y], ...more } });
  }
  function openPort(id: string, name: string, element: Element): void {
    const box = element.getBoundingClientRect();
    open(inside(box.left, box.bottom), { port: { id, name } });
  }
  function middle(): { x: number; y: number } {
    const box = place.current?.getBoundingClientRect();
    return { x: (box?.left ?? 0) + (box?.width ?? 0) / 2, y: (box?.top ?? 0) + (box?.height ?? 0) / 3 };
  }

  function endConnection(event: MouseEvent | TouchEvent, end: FinalConnectionState): void {
    if (end.isValid || !end.fromNode || !end.fromHandle) return;
    const from = graph.byId.get(end.fromNode.id);
    const to = end.toNode && end.toHandle ? graph.byId.get(end.toNode.id) : undefined;
    const isSource = end.fromHandle.type === 'source';
    const [source, target] = isSource ? [from, to] : [to, from];
    const handle = isSource ? end.toHandle : end.fromHandle;
    const input = target?.inputs.find((i) => INPUT + i.name === handle?.id);
    if (source && target && input) {
      say(edgeProblem(graph, source, target, input));
      return;
    }
    if (end.toNode) return;
    const point = 'changedTouches' in event ? event.changedTouches[0] : event;
    if (!point || !from) return;
    const name = end.fromHandle.id?.slice(INPUT.length) ?? '';
    openAdd(
      point.clientX,
      point.clientY,
      isSource ? { source: from.id } : { target: { id: from.id, input: name } },
    );
  }

  function isValid(connection: FlowConnection | Edge): boolean {
    const source = graph.byId.get(connection.source);
    const target = graph.byId.get(connection.target);
    const input = target?.inputs.find((i) => INPUT + i.name === connection.targetHandle);
    return (
      source !== undefined &&
      target !== undefined &&
      input !== undefined &&
      edgeProblem(graph, source, target, input) === ''
    );
  }

  function join(connection: FlowConnection, without?: GraphEdge): void {
    connectNodes(
      connection.source,
      connection.target,
      connection.targetHandle?.slice(INPUT.length) ?? '',
      without,
    );
  }

  function endDrag(
    event: ReactMouseEvent | MouseEvent | TouchEvent,
    card: CardNode,
    moved: readonly CardNode[],
  ): void {
    const under =
      'clientX' in event && moved.length === 1
        ? document.elementsFromPoint(event.clientX, event.clientY)
        : [];
    const edge = under
      .map((e) => e.closest('.react-flow__edge')?.getAttribute('data-id'))
      .find((id) => typeof id === 'string');
    const at: Position = [card.position.x, card.position.y];
    if (edge && insertNode(card.id, edge, at)) return;
    move(new Map(moved.map((c): [string, Position] => [c.id, [c.position.x, c.position.y]])));
  }

  const fitting = (at: AddPlace): Fitting | undefined => {
    if (at.source !== undefined) return { gives: graph.byId.get(at.source)?.gives };
    const input = at.target && graph.byId.get(at.target.id)?.inputs.find((i) => i.name === at.target?.input);
    return input && { input };
  };

  async function arrange(): Promise<void> {
    const sizes = new Map(
      cards.map((c) => [c.id, { width: c.measured?.width ?? 190, height: c.measured?.height ?? 100 }]),
    );
    move(await arranged(graph, sizes));
    setTimeout(sight.fit, 50);
  }

  const selectedEdges = (): GraphEdge[] => {
    const chosen = new Set(edges.filter((e) => e.selected).map((e) => e.id));
    return graph.edges.filter((e) => chosen.has(e.id));
  };

  const onNodesChange = useStable((changes: NodeChange<CardNode>[]) => {
    const chosen = withSelection(useGraphStore.getState().selection, changes);
    if (chosen) select(chosen);
    const others = changes.filter((c) => c.type !== 'select');
    for (const c of others) if (c.type === 'dimensions' && c.dimensions) cardSizes.set(c.id, c.dimensions);
    if (others.length > 0) setCards((before) => applyNodeChanges(others, before));
    // The keys of a node that is focused move it, too; a drag ends in endDrag().
    const byKey = changes.flatMap((c): [string, Position][] =>
      c.type === 'position' &&
      c.dragging === false &&
      c.position &&
      !cards.some((n) => n.id === c.id && n.dragging)
        ? [[c.id, [c.position.x, c.position.y]]]
        : [],
    );
    if (byKey.length > 0) move(new Map(byKey), 'move by keys');
  });
  const onEdgesChange = useStable((changes: EdgeChange[]) =>
    setEdges((before) => applyEdgeChanges(changes, before)),
  );
  const onNodeDragStop = useStable(endDrag);
  const onNodeDoubleClick = useStable((_: unknown, card: CardNode) => {
    if (card.data.node.role === 'view') openView(card.data.node.name);
  });
  const onConnect = useStable((connection: FlowConnection) => join(connection));
  const onConnectStart = useStable((_: unknown, { nodeId, handleId }: OnConnectStartParams) => {
    say('');
    beginDragging(graph, { node: nodeId ?? '', port: handleId ?? '' });
  });
  const onConnectEnd = useStable((...ended: Parameters<typeof endConnection>) => {
    endDragging();
    endConnection(...ended);
  });
  const onMoveStart = useStable((event: unknown) => {
    if (event) sight.release(); // Else the page has moved the canvas itself.
  });
  const onReconnect = useStable((edge: Edge, connection: FlowConnection) =>
    join(
      connection,
      graph.edges.find((e) => e.id === edge.id),
    ),
  );
  const isValidConnection = useStable(isValid);

  const shownMenu = opened?.place ? (
    <Menu
      name="Add: type a name, or a file's path"
      at={opened}
      items={(typed) =>
        matching(
          items.filter((item) => fits(item, fitting(opened.place as AddPlace))),
          typed,
        ).map((item, i) => ({ ...item, key: `${i} ${item.label}` }))
      }
      onClose={close}
      onChoose={(item) => {
        const id = addItem(item, opened.place as AddPlace);
        close();
        focusCard(id); // Keys go on at the new node.
      }}
    />
  ) : opened?.port ? (
    <Menu
      name={opened.port.name === OUTPUT ? 'Connect this output to' : 'Connect this input with'}
      at={opened}
      items={(typed) => withWords(portItems(graph, opened.port?.id ?? '', opened.port?.name ?? ''), typed)}
      onClose={close}
      onChoose={(item) => {
        connectNodes(item.source, item.target, item.input);
        close();
      }}
    />
  ) : null;

  return (
    // Keys of the canvas. Nodes, edges and ports inside have the focus themselves.
    <div
      ref={place}
      className="graph-canvas"
      role="application"
      aria-label="Canvas of the graph. A adds a node, C at a port connects it."
      tabIndex={0}
      onPointerDown={() => {
        byMouse.current = true;
        if (message !== '') say('');
      }}
      onKeyDown={(event) => {
        const wasByMouse = byMouse.current;
        byMouse.current = false;
        onCanvasKey(event, {
          selection,
          edges: selectedEdges,
          isByMouse: wasByMouse && (event.target === place.current || event.target === document.body),
          openAdd: (target) => {
            const at = middle();
            openAdd(at.x, at.y, target ?? {});
          },
          openPort,
          arrange: () => void arrange(),
          fit: sight.fitAll,
        });
      }}
      onClick={(event) => {
        const port = portOf(event.target);
        if (port) openPort(port.id, port.port, port.element);
      }}
      onDoubleClick={(event) => {
        if ((event.target as Element).classList.contains('react-flow__pane'))
          openAdd(event.clientX, event.clientY);
      }}
      onCopy={(event: ClipboardEvent) => {
        const text = isTyping(event.target) ? '' : copied(selection);
        if (text === '') return;
        event.clipboardData.setData('text/plain', text);
        event.preventDefault();
      }}
      onPaste={(event: ClipboardEvent) => {
        if (isTyping(event.target)) return;
        if (!pasted(event.clipboardData.getData('text/plain')))
          say('What was copied is no part of a state file.');
        event.preventDefault();
      }}
      onDragOver={(event: DragEvent) => {
        if (event.dataTransfer.types.includes(DATASET)) event.preventDefault();
      }}
      onDrop={(event: DragEvent) => {
        const name = event.dataTransfer.getData(DATASET);
        const at = flow.screenToFlowPosition({ x: event.clientX, y: event.clientY });
        if (name !== '') void showDataset(name, [at.x, at.y]);
      }}
    >
      <ReactFlow<CardNode>
        nodes={cards}
        edges={edges}
        nodeTypes={TYPES}
        onNodesChange={onNodesChange}
        onEdgesChange={onEdgesChange}
        onNodeDragStop={onNodeDragStop}
        onNodeDoubleClick={onNodeDoubleClick}
        onConnect={onConnect}
        onConnectStart={onConnectStart}
        onConnectEnd={onConnectEnd}
        onMoveStart={onMoveStart}
        onReconnect={onReconnect}
        isValidConnection={isValidConnection}
        connectionLineType={ConnectionLineType.Bezier}
        deleteKeyCode={null}
        nodesDraggable={snapshot?.isViewOnly !== true}
        nodesConnectable={snapshot?.isViewOnly !== true}
        zoomOnDoubleClick={false}
        multiSelectionKeyCode={MULTI_SELECTION}
        minZoom={0.1}
        onlyRenderVisibleElements={cards.length > 200}
        colorMode="system"
      >
        <Background gap={24} />
        <Controls
          orientation="horizontal"
          showInteractive={false}
          fitViewOptions={FIT}
          onZoomIn={sight.release}
          onZoomOut={sight.release}
          onFitView={sight.fitAll}
        />
      </ReactFlow>
      {graph.nodes.length === 0 && isLoaded && !snapshot.isViewOnly && (
        <p className="canvas-hint">Double click or press A to add a node, or drag data here.</p>
      )}
      {shownMenu}
      <div className="canvas-message" role="status">
        {message}
      </div>
    </div>
  );
}

/** The ids that are selected after changes by the user; undefined: these change no selection. */
function withSelection(
  before: readonly string[],
  changes: readonly NodeChange<CardNode>[],
): readonly string[] | undefined {
  const made = changes.filter((c) => c.type === 'select');
  if (made.length === 0) return undefined;
  const off = new Set(made.map((c) => c.id));
  return [...before.filter((id) => !off.has(id)), ...made.filter((c) => c.selected).map((c) => c.id)];
}

function isTyping(target: EventTarget): boolean {
  return target instanceof Element && target.closest('input, textarea, select, [contenteditable]') !== null;
}

export function GraphCanvas() {
  return (
    <ReactFlowProvider>
      <Canvas />
    </ReactFlowProvider>
  );
}
