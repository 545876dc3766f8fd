// SPDX-License-Identifier: Apache-2.0
// The keys of the canvas.
import type { KeyboardEvent } from 'react';
import type { GraphEdge } from '../graph/nodes';
import { VIEW_ONLY } from '../graph/session';
import { savePython } from '../out/as_python';
import { type AddPlace, bypassNode, copied, openView, pasted, removeSelected } from './actions';
import { useGraphStore } from './graph_store';
import { INPUT, OUTPUT } from './titles';

export interface CanvasKeys {
  readonly selection: readonly string[];
  readonly edges: () => readonly GraphEdge[];
  /** The canvas has the focus by a click, so that Tab need not go on to the next node. */
  readonly isByMouse: boolean;
  readonly openAdd: (place?: Partial<AddPlace>) => void;
  readonly openPort: (id: string, port: string, element: Element) => void;
  readonly arrange: () => void;
  readonly fit: () => void;
}

/** For the list of keys. */
export const CANVAS_KEYS: readonly (readonly [keys: string, meaning: string])[] = [
  ['A, double click, Tab after a click', 'add a node'],
  ['C at a port', 'connect it; A there adds a node that fits'],
  ['Delete', 'remove what is selected'],
  ['F2', 'rename the node'],
  ['Enter at a view', 'show the view'],
  ['Ctrl+C, Ctrl+V, Ctrl+D', 'copy as a state file, paste, duplicate'],
  ['Ctrl+Z, Ctrl+Y', 'undo, redo your own edits'],
  ['B', 'bypass the node'],
  ['L, F', 'lay out, fit into the canvas'],
  ['P', 'save as a Python program'],
];

/** The node and the port whose element has the focus. */
export function portOf(target: EventTarget): { id: string; port: string; element: Element } | undefined {
  if (!(target instanceof Element)) return undefined;
  const element = target.closest('[data-port]');
  const id = target.closest('.react-flow__node')?.getAttribute('data-id');
  return element && id ? { id, port: element.getAttribute('data-port') ?? OUTPUT, element } : undefined;
}

const EDITING = ['a', 'A', 'c', 'C', 'Delete', 'Backspace', 'F2', 'b', 'l'];

export function onCanvasKey(event: KeyboardEvent, keys: CanvasKeys): void {
  if (event.target instanceof Element && event.target.closest('input, textarea, select')) return;
  if (event.altKey) return;
  const isDone = event.ctrlKey || event.metaKey ? withControl(event, keys) : plain(event, keys);
  if (isDone) {
    event.preventDefault();
    event.stopPropagation();
  }
}

function withControl(event: KeyboardEvent, { selection }: CanvasKeys): boolean {
  if (undoes(event)) return true;
  if (event.key.toLowerCase() !== 'd') return false;
  pasted(copied(selection));
  return true;
}

function undoes(event: KeyboardEvent): boolean {
  const { session } = useGraphStore.getState();
  const key = event.key.toLowerCase();
  if (key === 'z' && !event.shiftKey) session?.undo();
  else if (key === 'y' || key === 'z') session?.redo();
  else return false;
  return true;
}

/** Undo and redo of the graph where nothing is typed: a field has its own for what is typed into it. */
export function onUndoKey(event: KeyboardEvent): void {
  if (event.altKey || !(event.ctrlKey || event.metaKey)) return;
  if (event.target instanceof Element && event.target.closest('input:not([type=checkbox]), textarea')) return;
  if (undoes(event)) event.preventDefault();
}

function plain(event: KeyboardEvent, keys: CanvasKeys): boolean {
  const { selection } = keys;
  const { session, say } = useGraphStore.getState();
  if (session?.snapshot.isViewOnly && EDITING.includes(event.key)) {
    say(VIEW_ONLY);
    return true;
  }
  const port = portOf(event.target);
  const node =
    event.target instanceof Element
      ? event.target.closest('.react-flow__node')?.getAttribute('data-id')
      : undefined;
  const one = node ?? (selection.length === 1 ? selection[0] : undefined);
  switch (event.key) {
    case 'a':
    case 'A':
      if (!port) keys.openAdd();
      else if (port.port === OUTPUT) keys.openAdd({ source: port.id });
      else keys.openAdd({ target: { id: port.id, input: port.port.slice(INPUT.length) } });
      return true;
    case 'Tab':
      if (!keys.isByMouse || event.shiftKey) return false;
      keys.openAdd();
      return true;
    case 'c':
    case 'C':
      if (port) keys.openPort(port.id, port.port, port.element);
      return port !== undefined;
    case 'Delete':
    case 'Backspace':
      removeSelected(node && !selection.includes(node) && !port ? [node] : selection, keys.edges());
      // What had the focus may be gone.
      (event.currentTarget as HTMLElement).focus({ preventScroll: true });
      return true;
    case 'F2':
      document.querySelector<HTMLInputElement>('[data-property="name"]')?.focus();
      return true;
    case 'Enter':
      if (port) keys.openPort(port.id, port.port, port.element);
      else if (one?.startsWith('Visualizations/')) openView(one.slice('Visualizations/'.length));
      return port !== undefined;
    case 'b':
      if (one) bypassNode(one);
      return true;
    case 'l':
      keys.arrange();
      return true;
    case 'f':
      keys.fit();
      return true;
    case 'p':
      savePython();
      return true;
    default:
      return false;
  }
}
