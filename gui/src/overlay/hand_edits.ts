// SPDX-License-Identifier: Apache-2.0
// Edits that a hand makes in the picture. While it moves, they are given at the pace of frames: the next one once a frame has come after the one
// before, so that the server is not asked for pictures that nobody would see.
import { applied, type Edit, EditError, type Path } from '../graph/edits';
import type { Json, JsonObject } from '../graph/json';
import type { View } from '../view/view';
import type { LookEditor } from './look_editor';

const AT_MOST = 500; // milliseconds: an edit may change no picture, so no frame comes
let gestures = 0;

interface Drag {
  readonly gesture: string;
  readonly path: Path;
  to?: Json; // where the hand is
  given?: Json; // the last value that was given to the editor
}

export class HandEdits {
  private drag: Drag | null = null;
  private frame = 0; // the one that was shown when the last edit was given
  private givenAt = -Infinity;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly listeners = new Set<() => void>();
  private draftNow: Edit | null = null;

  constructor(
    private readonly view: Pick<View, 'frameShown' | 'subscribe'>,
    private readonly editor: Pick<LookEditor, 'edit' | 'undo' | 'redo'>,
  ) {}

  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  /** What the hand holds and the document does not say yet. */
  get draft(): Edit | null {
    return this.draftNow;
  }

  begin(path: Path): void {
    this.drag = { gesture: `hand ${++gestures}`, path };
    this.stopListening();
    this.stopListening = this.view.subscribe(() => {
      this.giveIfDue();
    });
  }

  move(to: Json): void {
    if (!this.drag) return;
    this.drag.to = to;
    this.giveIfDue();
    this.setDraft({ set: this.drag.path, to });
  }

  /** The hand lets go: what it holds is final. */
  end(): void {
    const { drag } = this;
    if (drag?.to !== undefined) this.give(drag, drag.to, false);
    this.finish();
  }

  /** What was there before the hand took it is back, and nothing is left to be undone. */
  cancel(): void {
    if (this.drag?.given !== undefined) this.editor.undo();
    this.finish();
  }

  /** One step by keys. Steps that follow each other are undone together. */
  step(path: Path, to: Json): void {
    this.editor.edit([{ set: path, to }], `keys ${path.join('/')}`, false);
  }

  undo(): void {
    this.editor.undo();
  }
  redo(): void {
    this.editor.redo();
  }

  get isHolding(): boolean {
    return this.drag !== null;
  }

  private stopListening: () => void = () => undefined;

  private finish(): void {
    clearTimeout(this.timer);
    this.stopListening();
    this.drag = null;
    this.setDraft(null);
  }

  private giveIfDue(): void {
    const { drag } = this;
    if (drag?.to === undefined || drag.to === drag.given) return;
    clearTimeout(this.timer);
    const wait = this.givenAt + AT_MOST - performance.now();
    if (this.view.frameShown > this.frame || wait <= 0) this.give(drag, drag.to, true);
    else this.timer = setTimeout(() => this.giveIfDue(), wait);
  }

  private give(drag: Drag, to: Json, live: boolean): void {
    drag.given = to;
    this.frame = this.view.frameShown;
    this.givenAt = performance.now();
    this.editor.edit([{ set: drag.path, to }], drag.gesture, live);
  }

  private setDraft(draft: Edit | null): void {
    this.draftNow = draft;
    for (const listener of [...this.listeners]) listener();
  }
}

/** The document with what the hand holds. */
export function withDraft(document: JsonObject, draft: Edit | null): JsonObject {
  if (!draft) return document;
  try {
    return applied(document, [draft]).document;
  } catch (error) {
    if (error instanceof EditError) return document; // What the hand holds is not there any more.
    throw error;
  }
}
