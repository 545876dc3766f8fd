// SPDX-License-Identifier: Apache-2.0
// Undo and redo of one's own edits, in a document that others edit, too.
//
// An entry is the list of edits that the server said would undo an edit. While it waits, others may edit the document. An entry follows
// elements that get other names or places; it goes if it would take back what somebody else has done since.
import { type Edit, type Path, applied, find, SECTIONS } from './edits';
import { type Json, type JsonObject, equal, isList, member } from './json';

export function pathOf(edit: Edit): Path {
  if ('set' in edit) return edit.set;
  if ('add' in edit) return edit.add;
  return 'remove' in edit ? edit.remove : edit.rename;
}

function withPath(edit: Edit, path: Path): Edit {
  if ('set' in edit) return { ...edit, set: path };
  if ('add' in edit) return { ...edit, add: path };
  return 'remove' in edit ? { remove: path } : { ...edit, rename: path };
}

/** A path with the names of elements in place of their indices, where they have names. */
function namedPath(document: Json, path: Path): Path {
  return path.map((step, i) => {
    const name = typeof step === 'number' ? member(find(document, path.slice(0, i + 1)), 'name') : step;
    return typeof name === 'string' && name !== '' ? name : step;
  });
}

/** Edits that say the same with names in place of indices, so that they mean the same elements also after others have edited. */
export function named(document: JsonObject, edits: readonly Edit[]): readonly Edit[] {
  let current = document;
  return edits.map((edit) => {
    const out = withPath(edit, namedPath(current, pathOf(edit)));
    current = applied(current, [edit]).document;
    return out;
  });
}

function startsWith(path: Path, begin: Path): boolean {
  return begin.length <= path.length && begin.every((step, i) => step === path[i]);
}

/** Whether a path goes through the list by a number. */
function counts(path: Path, list: Path): boolean {
  return startsWith(path, list) && typeof path[list.length] === 'number';
}

/** An edit of somebody else, as far as it matters to edits that wait. */
interface Foreign {
  readonly edit: Edit;
  readonly path: Path; // with names in place of indices
  readonly list: Path | undefined; // whose elements it moves
}

function foreign(document: JsonObject, edits: readonly Edit[]): readonly Foreign[] {
  let current = document;
  return edits.map((edit) => {
    const path = namedPath(current, pathOf(edit));
    const isElement = 'remove' in edit && isList(find(current, path.slice(0, -1)));
    current = applied(current, [edit]).document;
    return { edit, path, list: 'add' in edit ? path : isElement ? path.slice(0, -1) : undefined };
  });
}

/** The edit after somebody else's; undefined if it would undo that one or has lost its element. */
function after(edit: Edit, { edit: other, path: there, list }: Foreign): Edit | undefined {
  const path = pathOf(edit);
  if ('rename' in other) {
    const isSection = SECTIONS.some((s) => s === there[0]);
    if (!isSection || path[0] !== there[0] || path[1] !== there[1]) return edit;
    const isOfName = 'rename' in edit || path[2] === 'name';
    return isOfName ? undefined : withPath(edit, [path[0] as string, other.to, ...path.slice(2)]);
  }
  if (list && counts(path, list)) return undefined;
  return !('add' in other) && startsWith(path, there) ? undefined : edit;
}

/** A list of edits after those of somebody else; undefined if one of them would undo these. */
function afterOthers(edits: readonly Edit[], others: readonly Foreign[]): readonly Edit[] | undefined {
  let out = edits;
  for (const other of others) {
    const next = out.map((edit) => after(edit, other));
    if (next.some((edit) => edit === undefined)) return undefined;
    out = next as readonly Edit[];
  }
  return out;
}

/** Edits whose elements are added at places that are there, although others have made the lists shorter. */
export function clamped(document: JsonObject, edits: readonly Edit[]): readonly Edit[] {
  let current = document;
  return edits.map((edit) => {
    const list = 'add' in edit ? find(current, edit.add) : undefined;
    const out =
      'add' in edit && isList(list) && (edit.at ?? 0) > list.length ? { ...edit, at: list.length } : edit;
    current = applied(current, [out]).document;
    return out;
  });
}

interface Entry {
  readonly gesture: string; // entries of one gesture, such as a drag, are undone together
  readonly inverse: readonly Edit[];
  readonly isUnderWay?: boolean; // its edits are sent, and the server has not ordered them yet
}

const MOST_ENTRIES = 200;

export class UndoStacks {
  private undos: Entry[] = [];
  private redos: Entry[] = [];

  get canUndo(): boolean {
    return this.undos.some((entry) => !entry.isUnderWay);
  }
  get canRedo(): boolean {
    return this.redos.some((entry) => !entry.isUnderWay);
  }

  /** Takes the inverse of an edit, in the document after that edit. Edits of one `gesture` that is not empty are one step. */
  push(inverse: readonly Edit[], document: JsonObject, kind: 'edit' | 'undo' | 'redo', gesture = ''): void {
    const entry = { gesture, inverse: named(document, inverse) };
    if (kind === 'undo') {
      this.redos.push(entry);
      if (this.redos.length > MOST_ENTRIES) this.redos.shift();
      return;
    }
    if (kind === 'edit') this.redos = [];
    const last = this.undos[this.undos.length - 1];
    if (last && gesture !== '' && last.gesture === gesture)
      this.undos[this.undos.length - 1] = merged(entry, last);
    else this.undos.push(entry);
    if (this.undos.length > MOST_ENTRIES) this.undos.shift();
  }

  /** Begins the newest step; undefined if there is none. The step stays here until end(), since the server may refuse it. */
  begin(kind: 'undo' | 'redo'): readonly Edit[] | undefined {
    const entries = kind === 'undo' ? this.undos : this.redos;
    const last = entries.pop();
    if (last) entries.push({ ...last, isUnderWay: true });
    return last?.inverse;
  }

  /** The step that was begun is done, or cannot be done any more. */
  end(): void {
    this.undos = this.undos.filter((entry) => !entry.isUnderWay);
    this.redos = this.redos.filter((entry) => !entry.isUnderWay);
  }

  /** The step that was begun has not been done, and can be begun again. */
  release(): void {
    const released = (entry: Entry): Entry => ({ ...entry, isUnderWay: false });
    this.undos = this.undos.map(released);
    this.redos = this.redos.map(released);
  }

  /** Somebody else, or this client outside its history, has edited `document`. Returns how many steps went. */
  others(edits: readonly Edit[], document: JsonObject): number {
    const before = this.undos.length + this.redos.length;
    if (before === 0) return 0;
    const theirs = foreign(document, edits);
    const keep = (entries: Entry[]): Entry[] =>
      entries.flatMap((entry) => {
        const inverse = afterOthers(entry.inverse, theirs);
        return inverse ? [{ ...entry, inverse }] : [];
      });
    this.undos = keep(this.undos);
    this.redos = keep(this.redos);
    return before - this.undos.length - this.redos.length;
  }

  clear(): void {
    this.undos = [];
    this.redos = [];
  }
}

/** One entry for two of a gesture. Where both say what the same paths were, the older says it. */
function merged(newer: Entry, older: Entry): Entry {
  const known = older.inverse.map(pathOf);
  const isCovered = newer.inverse.every(
    (edit) => 'set' in edit && known.some((path) => equal(path as Json, edit.set as Json)),
  );
  return isCovered ? older : { gesture: older.gesture, inverse: [...newer.inverse, ...older.inverse] };
}
