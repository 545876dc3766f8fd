// SPDX-License-Identifier: Apache-2.0
// How the mouse or a finger takes a handle, moves it and lets it go. Escape brings back what was there.
import { type KeyboardEvent, type PointerEvent, useRef } from 'react';
import type { Path } from '../graph/edits';
import type { Json } from '../graph/json';
import type { HandEdits } from './hand_edits';
import type { Point } from './projection';

/** The place of a pointer in the drawing that an element belongs to. */
function placeOf(event: PointerEvent<SVGElement>): Point {
  const box = event.currentTarget.ownerSVGElement?.getBoundingClientRect();
  return { x: event.clientX - (box?.left ?? 0), y: event.clientY - (box?.top ?? 0) };
}

/**
 * Returns the handlers of an element that holds the value at `path`. `begin` is called with the place where it is taken, and returns what
 * gives the value for each place where the hand goes. `onKey` takes keys while no hand holds it, and returns whether it had a use for them.
 */
export function useHand(
  hands: HandEdits,
  path: Path,
  begin: (from: Point) => (to: Point) => Json,
  onKey: (event: KeyboardEvent) => boolean,
  onEnd: () => void = () => undefined,
) {
  const motion = useRef<(to: Point) => Json>(undefined);
  function finish(isTaken: boolean): void {
    if (!motion.current) return;
    motion.current = undefined;
    if (isTaken) hands.end();
    else hands.cancel();
    onEnd();
  }
  return {
    onPointerDown(event: PointerEvent<SVGElement>): void {
      if (event.button !== 0 || hands.isHolding) return;
      event.preventDefault();
      event.currentTarget.focus();
      event.currentTarget.setPointerCapture(event.pointerId);
      motion.current = begin(placeOf(event));
      hands.begin(path);
    },
    onPointerMove(event: PointerEvent<SVGElement>): void {
      if (motion.current) hands.move(motion.current(placeOf(event)));
    },
    onPointerUp(): void {
      finish(true);
    },
    onPointerCancel(): void {
      finish(false);
    },
    onKeyDown(event: KeyboardEvent): void {
      const isDone = motion.current ? event.key === 'Escape' : onKey(event);
      if (motion.current && isDone) finish(false);
      if (!isDone) return;
      event.preventDefault();
      event.stopPropagation();
    },
  };
}

/** By how many steps an arrow key moves a value: 1 or -1, a tenth with Shift; 0: it is another key. */
export function stepsOf(event: KeyboardEvent): number {
  const sign = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1 }[event.key] ?? 0;
  return event.shiftKey ? sign / 10 : sign;
}
