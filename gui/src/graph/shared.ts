// SPDX-License-Identifier: Apache-2.0
// A document that several clients edit. The server orders all edits; this client's own are shown at once, on top of what the server has
// ordered so far, and again on top of what it orders before them.
import { difference } from './difference';
import { type Edit, EditError, type Edited, applied } from './edits';
import { type Json, type JsonObject, equal } from './json';
import { UndoStacks, clamped, named } from './undo';

export interface OwnEdit {
  readonly edits: readonly Edit[];
  /** More follow soon, as of a slider that is being dragged. Of such edits of a gesture that wait, only the newest is sent. */
  readonly live?: boolean;
  /** Edits of one gesture are undone together. */
  readonly gesture?: string;
  /** `none`: undo leaves it, as the camera of a view. */
  readonly history?: 'edit' | 'undo' | 'redo' | 'none';
}

/** An edit as the server tells it to all who watch the graph. */
export interface OrderedEdit {
  readonly revision: number;
  readonly edits: readonly Edit[];
  readonly isOwn: boolean;
}

/** An own edit with its number. An edit that is sent again has the number of before, by which the server knows it. */
export interface NumberedEdit extends OwnEdit {
  readonly number: number;
}

interface Pending {
  readonly own: OwnEdit;
  number?: number; // once it was sent
  revision?: number; // once the server has said it
}

export class SharedDocument {
  readonly history = new UndoStacks();
  private base: JsonObject = {}; // what the server has ordered, as far as it is known here
  private baseRevision = 0;
  private pending: Pending[] = []; // own edits that `base` does not have, oldest first
  private sent: Pending | undefined; // the one that the server has not replied to
  private lastNumber = 0;
  private shownDocument: JsonObject = {};

  /** The document as the user sees it: the server's, with one's own edits that it has not ordered yet. */
  get shown(): JsonObject {
    return this.shownDocument;
  }
  get revision(): number {
    return this.baseRevision;
  }
  /** What the server has ordered, without own edits that wait. */
  get server(): JsonObject {
    return this.base;
  }
  /** How many own edits the server has not ordered yet. */
  get waiting(): number {
    return this.pending.length;
  }

  /** Begins with the server's document, or goes on with a newer one after events were lost. Own edits that it lacks stay on top. */
  reset(document: JsonObject, revision: number): void {
    const isOrdered = (p: Pending): boolean => p.revision !== undefined && p.revision <= revision;
    const known = this.pending.filter(isOrdered).reduce((d, p) => this.takeOrdered(p, d), this.base);
    this.history.others(difference(known, document), known);
    // A graph that was made anew has none of the edits of before.
    if (revision < this.baseRevision) for (const p of this.pending) delete p.revision;
    this.base = document;
    this.baseRevision = revision;
    this.show();
  }

  /** Adds an own edit. Throws EditError, and adds nothing, if it cannot be applied to what is shown. */
  add(own: OwnEdit): void {
    const entry: Pending = { own: { ...own, edits: named(this.shownDocument, own.edits) } };
    const last = this.pending[this.pending.length - 1];
    const replaces = last && last.number === undefined && isReplacedBy(last.own, entry.own);
    const shown = applied(this.shownDocument, entry.own.edits).document;
    if (replaces) this.pending.pop();
    this.pending.push(entry);
    this.shownDocument = shown;
  }

  /** The next edit to be sent, which then counts as sent; undefined if there is none, or while one is on its way. */
  next(): NumberedEdit | undefined {
    if (this.sent) return undefined;
    this.sent = this.pending.find((p) => p.revision === undefined);
    if (!this.sent) return undefined;
    this.sent.number ??= ++this.lastNumber;
    return { ...this.sent.own, number: this.sent.number };
  }

  /** Whether the next edit was sent before the connection was lost, so that the server may have ordered it. */
  get isUnsure(): boolean {
    return this.pending.find((p) => p.revision === undefined)?.number !== undefined;
  }

  /** The server has replied to the edit that was sent. Its event may have come already, or comes later. */
  accepted(revision: number): void {
    if (!this.sent) return;
    this.sent.revision = revision;
    if (revision <= this.baseRevision) this.drop(this.sent);
    this.sent = undefined;
    this.show();
  }

  /** The server has refused the edit that was sent, or the connection was lost: then it is to be sent `again`. */
  refused(again = false): void {
    const { sent } = this;
    if (sent && !again) {
      this.drop(sent);
      if (isStep(sent.own)) this.history.release();
    }
    this.sent = undefined;
    this.show();
  }

  /** The server has ordered an edit. Returns false if others before it are missing here: then the document has to be read again. */
  ordered(edit: OrderedEdit): boolean {
    if (edit.revision <= this.baseRevision) return true;
    if (edit.revision !== this.baseRevision + 1) return false;
    const before = this.base;
    const edited = applied(before, edit.edits);
    this.base = edited.document;
    this.baseRevision = edit.revision;
    const entry = edit.isOwn ? this.ownOf(edit) : undefined;
    if (entry) this.remember(entry, edit.edits, before, edited);
    else this.history.others(edit.edits, before);
    this.show();
    return true;
  }

  /** An own edit is in the server's order: it can be undone now. */
  private remember({ own }: Pending, edits: readonly Edit[], before: JsonObject, edited: Edited): void {
    this.pending = this.pending.filter((p) => p.own !== own);
    if (isStep(own)) this.history.end();
    const kind = own.history ?? 'edit';
    if (kind === 'none') this.history.others(edits, before);
    else this.history.push(edited.inverse, edited.document, kind, own.gesture);
  }

  /** The server has ordered an own edit, and its event was lost. Returns what is known of the document then, of which `before` was known. */
  private takeOrdered(entry: Pending, before: JsonObject): JsonObject {
    const { edits } = entry.own;
    try {
      const edited = applied(before, edits);
      this.remember(entry, edits, before, edited);
      return edited.document;
    } catch (error) {
      if (!(error instanceof EditError)) throw error;
      this.drop(entry); // It needed what others had done before it, so it is not known what would undo it.
      if (isStep(entry.own)) this.history.end();
      return before;
    }
  }

  /**
   * The edits of the newest own step, to be added at once; undefined if there is none, or it cannot be undone any more. While own edits
   * wait, there is none: which step is the newest is known only when they are ordered.
   */
  step(kind: 'undo' | 'redo'): readonly Edit[] | undefined {
    if (this.waiting > 0) return undefined;
    const edits = this.history.begin(kind);
    try {
      return edits && clamped(this.shownDocument, edits);
    } catch {
      this.history.end(); // so that the steps before it can still be undone
      return undefined;
    }
  }

  // An event may come before the reply. It may also be of an edit that this page sent before it opened the graph again.
  private ownOf(edit: OrderedEdit): Pending | undefined {
    const known = this.pending.find((p) => p.revision === edit.revision);
    const isSent = equal(this.sent?.own.edits as Json | undefined, edit.edits as unknown as Json);
    return known ?? (isSent ? this.sent : undefined);
  }

  private drop(entry: Pending): void {
    this.pending = this.pending.filter((p) => p !== entry);
  }

  // An own edit that cannot be applied any more, after what the server has ordered before it, is left out: the server will refuse it.
  private show(): void {
    this.shownDocument = this.pending.reduce((d, p) => tryApplied(d, p.own.edits) ?? d, this.base);
  }
}

function tryApplied(document: JsonObject, edits: readonly Edit[]): JsonObject | undefined {
  try {
    return applied(document, edits).document;
  } catch {
    return undefined;
  }
}

function isStep({ history }: OwnEdit): boolean {
  return history === 'undo' || history === 'redo';
}

/** Whether a live edit that waits need not be sent, since the newer one sets the same. */
function isReplacedBy(older: OwnEdit, newer: OwnEdit): boolean {
  const paths = (edits: readonly Edit[]): string =>
    JSON.stringify(edits.map((e) => ('set' in e ? e.set : e)));
  return (
    older.live === true &&
    older.gesture !== undefined &&
    older.gesture === newer.gesture &&
    paths(older.edits) === paths(newer.edits)
  );
}
