// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { Edit } from '../graph/edits';
import { HandEdits, withDraft } from './hand_edits';

class Stage {
  frameShown = 1;
  given: [to: unknown, gesture: string, live: boolean][] = [];
  undone = 0;
  private readonly listeners = new Set<() => void>();
  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };
  edit([edit]: readonly Edit[], gesture: string, live: boolean): void {
    this.given.push([edit && 'to' in edit ? edit.to : undefined, gesture, live]);
  }
  undo(): void {
    this.undone++;
  }
  redo(): void {
    this.undone--;
  }
  frame(): void {
    this.frameShown++;
    for (const listener of [...this.listeners]) listener();
  }
  get values(): unknown[] {
    return this.given.map(([to]) => to);
  }
}

let stage: Stage;
let hands: HandEdits;
beforeEach(() => {
  vi.useFakeTimers();
  stage = new Stage();
  hands = new HandEdits(stage, stage);
});
afterEach(() => {
  vi.useRealTimers();
});

it('while a hand moves, an edit is given once a frame has come after the one before, and the newest counts', () => {
  hands.begin(['a']);
  for (const value of [1, 2, 3]) hands.move(value);
  expect(stage.values).toEqual([1]);
  expect(hands.draft).toEqual({ set: ['a'], to: 3 });
  stage.frame();
  expect(stage.values).toEqual([1, 3]);
  stage.frame(); // The hand rests, so nothing is given.
  expect(stage.values).toEqual([1, 3]);
  hands.move(4);
  hands.end();
  expect(stage.given.map(([to, , live]) => [to, live])).toEqual([
    [1, true],
    [3, true],
    [4, true],
    [4, false],
  ]);
  expect(new Set(stage.given.map(([, gesture]) => gesture)).size).toBe(1);
  expect(hands.draft).toBeNull();
  stage.frame();
  expect(stage.given).toHaveLength(4);
});

it('goes on where an edit changes no picture, so that no frame comes', () => {
  hands.begin(['a']);
  hands.move(1);
  hands.move(2);
  vi.advanceTimersByTime(499);
  expect(stage.values).toEqual([1]);
  vi.advanceTimersByTime(1);
  expect(stage.values).toEqual([1, 2]);
});

it('two drags are two gestures, and a press without a motion is none', () => {
  for (const value of [1, 2]) {
    hands.begin(['a']);
    hands.move(value);
    hands.end();
    stage.frame();
  }
  hands.begin(['a']);
  hands.end();
  expect(new Set(stage.given.map(([, gesture]) => gesture)).size).toBe(2);
});

it('Escape takes back what was given, and nothing where nothing was', () => {
  hands.begin(['a']);
  hands.cancel();
  expect(stage.undone).toBe(0);
  hands.begin(['a']);
  hands.move(1);
  hands.move(2);
  hands.cancel();
  expect(stage.undone).toBe(1);
  stage.frame();
  vi.advanceTimersByTime(1000);
  expect(stage.values).toEqual([1]);
  expect(hands.draft).toBeNull();
});

it('what the hand holds is shown over the document, as long as its place is there', () => {
  const document = { Operators: [{ isovalues: [1, 2] }] };
  expect(withDraft(document, { set: ['Operators', 0, 'isovalues', 1], to: 5 })).toEqual({
    Operators: [{ isovalues: [1, 5] }],
  });
  expect(withDraft(document, { set: ['Operators', 3, 'isovalues', 1], to: 5 })).toBe(document);
});
