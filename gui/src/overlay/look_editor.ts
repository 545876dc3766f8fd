// SPDX-License-Identifier: Apache-2.0
// Where the looks of a view can be edited: in the document of its graph, or in the view's own document.
import { useMemo, useSyncExternalStore } from 'react';
import { useGraphStore } from '../canvas/graph_store';
import { applied, type Edit, EditError } from '../graph/edits';
import type { JsonObject } from '../graph/json';
import type { GraphSession } from '../graph/session';
import type { View } from '../view/view';
import type { JsonObject as WireObject } from '../wire/json';

export interface LookEditor {
  readonly document: JsonObject;
  /** The visualization: its name in a graph, or its number. */
  readonly which: string | number;
  readonly canEdit: boolean;
  edit(edits: readonly Edit[], gesture: string, live: boolean): void;
  /** Takes back the last gesture. */
  undo(): void;
  redo(): void;
  subscribe(listener: () => void): () => void;
}

class GraphLooks implements LookEditor {
  readonly subscribe: LookEditor['subscribe'];
  constructor(
    private readonly session: GraphSession,
    readonly which: string,
  ) {
    this.subscribe = session.subscribe;
  }
  get document(): JsonObject {
    return this.session.snapshot.document;
  }
  get canEdit(): boolean {
    return !this.session.snapshot.isViewOnly;
  }
  edit(edits: readonly Edit[], gesture: string, live: boolean): void {
    this.session.edit(edits, { gesture, live });
  }
  undo(): void {
    this.session.undo();
  }
  redo(): void {
    this.session.redo();
  }
}

/** A document of the view's own has no other editors, so its undo keeps whole documents. */
class OwnLooks implements LookEditor {
  readonly canEdit = true;
  private readonly before: { gesture: string; document: JsonObject }[] = [];
  private after: JsonObject[] = [];
  constructor(private readonly view: View) {}
  get document(): JsonObject {
    return (this.view.ownDocument ?? {}) as JsonObject;
  }
  get which(): number {
    return this.view.visualizationShown;
  }
  readonly subscribe = (listener: () => void): (() => void) => this.view.subscribe(listener);

  edit(edits: readonly Edit[], gesture: string): void {
    const { document } = this;
    try {
      this.show(applied(document, edits).document);
    } catch (error) {
      if (!(error instanceof EditError)) throw error;
      return; // What the hand holds is not there any more.
    }
    if (this.before[this.before.length - 1]?.gesture !== gesture) this.before.push({ gesture, document });
    this.after = [];
  }
  undo(): void {
    const last = this.before.pop();
    if (!last) return;
    this.after.push(this.document);
    this.show(last.document);
  }
  redo(): void {
    const next = this.after.pop();
    if (!next) return;
    this.before.push({ gesture: '', document: this.document });
    this.show(next);
  }
  private show(document: JsonObject): void {
    this.view.setDocument(document as WireObject);
  }
}

/** The document that has the looks of a view, and which visualization it is there; null if the page does not have it. */
export function lookDocument(view: View): { document: JsonObject; which: string | number } | null {
  const { ofGraph } = view;
  if (!ofGraph) return { document: (view.ownDocument ?? {}) as JsonObject, which: view.visualizationShown };
  const { session } = useGraphStore.getState();
  if (session?.name !== ofGraph.graph) return null;
  return { document: session.snapshot.document, which: ofGraph.view };
}

const NOTHING = { document: {} };

/** Edits the looks of a view; null if the view's graph is not the one that is open. `document` is that of now. */
export function useLookEditor(view: View): { editor: LookEditor | null; document: JsonObject } {
  const session = useGraphStore((s) => s.session);
  const editor = useMemo((): LookEditor | null => {
    const { ofGraph } = view;
    if (!ofGraph) return new OwnLooks(view);
    return session?.name === ofGraph.graph ? new GraphLooks(session, ofGraph.view) : null;
  }, [view, session]);
  const document = useSyncExternalStore(
    editor?.subscribe ?? NEVER,
    () => editor?.document ?? NOTHING.document,
  );
  return { editor, document };
}

const NEVER = (): (() => void) => () => undefined;
