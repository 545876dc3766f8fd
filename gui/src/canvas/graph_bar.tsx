// SPDX-License-Identifier: Apache-2.0
// The bar above the canvas: which graph is open, documents, undo, run and pause.
import { useRef, useState } from 'react';
import { saveGraph } from '../app/commands';
import { Foreign, printable } from '../app/foreign';
import { editing, useViewOnly } from '../app/view_only';
import { freeName } from '../graph/changes';
import { withNamedViews } from '../graph/fragment';
import type { JsonObject } from '../graph/json';
import { messageOf } from '../graph/session';
import { savePython } from '../out/as_python';
import { parseObject, type JsonObject as WireObject } from '../wire/json';
import {
  closeGraph,
  dropGraph,
  newGraph,
  openGraph,
  refreshGraphs,
  useGraphStore,
  useSnapshot,
} from './graph_store';

const LARGEST_DOCUMENT = 1 << 20; // docs/graph.md

/** Opens a state file of the user's machine as a new graph. */
async function openFile(file: File): Promise<void> {
  if (file.size > LARGEST_DOCUMENT) throw new Error(`${file.name}: expected at most 1 MiB`);
  const document = withNamedViews(parseObject(await file.text(), file.name) as JsonObject);
  const names = (await refreshGraphs()).map((g) => g.name);
  const name = file.name.replace(/\.json$/, '').replace(/[/\p{Cc}]/gu, '_');
  await newGraph(freeName(names, name || 'graph'), document as WireObject);
}

/** Makes an empty graph and opens it. */
export function freshGraph(): void {
  const { graphs, say } = useGraphStore.getState();
  const names = graphs.map((g) => g.name);
  newGraph(freeName(names, 'graph')).catch((error: unknown) => say(messageOf(error)));
}

function GraphChoice() {
  const { graphs, session } = useGraphStore();
  const isListed = graphs.some((g) => g.name === session?.name);
  return (
    <select
      aria-label="Graph"
      value={session?.name ?? ''}
      onFocus={() => void refreshGraphs().catch(() => undefined)}
      onChange={(event) => (event.target.value === '' ? closeGraph() : openGraph(event.target.value))}
    >
      <option value="">{graphs.length === 0 ? 'no graph yet' : 'open a graph'}</option>
      {session && !isListed && <option value={session.name}>{session.name}</option>}
      {graphs.map((g) => (
        <option key={g.name} value={g.name}>
          {g.name}
        </option>
      ))}
    </select>
  );
}

function RunButtons() {
  const session = useGraphStore((s) => s.session);
  const snapshot = useSnapshot();
  if (!session || !snapshot) return null;
  return (
    <>
      <button
        type="button"
        {...editing(snapshot.isViewOnly, 'Undo (Ctrl+Z)', !snapshot.canUndo)}
        aria-label="Undo"
        onClick={() => session.undo()}
      >
        ↶
      </button>
      <button
        type="button"
        {...editing(snapshot.isViewOnly, 'Redo (Ctrl+Y)', !snapshot.canRedo)}
        aria-label="Redo"
        onClick={() => session.redo()}
      >
        ↷
      </button>
      <button
        type="button"
        aria-pressed={snapshot.isPaused}
        {...editing(snapshot.isViewOnly)}
        onClick={() => session.setPaused(!snapshot.isPaused)}
      >
        {snapshot.isPaused ? 'Paused' : 'Pause'}
      </button>
      <button
        type="button"
        {...editing(snapshot.isViewOnly, 'Evaluate all nodes once, and try again what has failed')}
        onClick={() => session.run()}
      >
        {snapshot.unrun > 0 ? `Run (${snapshot.unrun} edits)` : 'Run'}
      </button>
    </>
  );
}

/** How many others watch the graph: people, programs, and further windows of the same person. */
function Others({ clients }: { readonly clients: readonly string[] }) {
  const count = clients.length - 1;
  if (count < 1) return null;
  return (
    <span className="weak" title={`Who watches this graph: ${clients.map(printable).join(', ')}`}>
      {count === 1 ? '1 other watches' : `${count} others watch`}
    </span>
  );
}

export function GraphBar() {
  const { session, say } = useGraphStore();
  const snapshot = useSnapshot();
  const file = useRef<HTMLInputElement>(null);
  const [isDropping, setDropping] = useState(false);
  const isViewOnly = useViewOnly();
  const attempt = (work: Promise<void>): void => void work.catch((error: unknown) => say(messageOf(error)));
  return (
    <div className="graph-bar" role="toolbar" aria-label="Graph">
      <GraphChoice />
      <button type="button" {...editing(isViewOnly)} onClick={freshGraph}>
        New
      </button>
      <input
        ref={file}
        type="file"
        accept=".json,application/json"
        className="unseen"
        tabIndex={-1}
        disabled={isViewOnly}
        aria-label="State file for a graph"
        onChange={({ currentTarget }) => {
          const chosen = currentTarget.files?.[0];
          if (chosen) attempt(openFile(chosen));
          currentTarget.value = '';
        }}
      />
      <button
        type="button"
        {...editing(isViewOnly, 'Open a state file as a graph')}
        onClick={() => file.current?.click()}
      >
        Open
      </button>
      {session && snapshot && (
        <>
          <button
            type="button"
            title="Save the graph as a state file"
            onClick={() => void saveGraph(session.name)}
          >
            Save
          </button>
          <button type="button" title="Save the graph as a Python program (P)" onClick={savePython}>
            As Python
          </button>
          {isDropping ? (
            <button
              type="button"
              className="danger"
              onBlur={() => setDropping(false)}
              onClick={() => {
                setDropping(false);
                attempt(dropGraph(session.name));
              }}
            >
              Delete {session.name}?
            </button>
          ) : (
            <button
              type="button"
              {...editing(isViewOnly, 'Have the server forget the graph; its data stay')}
              onClick={() => setDropping(true)}
            >
              Delete graph
            </button>
          )}
          <RunButtons />
          {snapshot.waiting > 0 && <span className="weak">{snapshot.waiting} unsent</span>}
          <Others clients={snapshot.clients} />
        </>
      )}
      {session && snapshot?.isGone && (
        <span role="alert">
          The server has no graph <Foreign text={session.name} />.{' '}
          <button type="button" {...editing(isViewOnly)} onClick={() => attempt(session.restore())}>
            Make it again
          </button>
        </span>
      )}
    </div>
  );
}
