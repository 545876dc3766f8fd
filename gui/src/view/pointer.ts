// SPDX-License-Identifier: Apache-2.0
// Mouse and touch in a view, as docs/viewer.md says. One finger turns, two move and zoom.
import type { Place } from './trackball';
import type { View } from './view';

type Motion = 'rotate' | 'pan' | 'zoom' | 'roll';

function motionOf(event: PointerEvent): Motion | null {
  if (event.pointerType === 'touch') return 'rotate';
  if (event.button === 1) return 'pan';
  if (event.button === 2) return 'zoom';
  if (event.button !== 0) return null;
  return event.shiftKey ? 'pan' : event.ctrlKey ? 'roll' : 'rotate';
}

const middleOf = (a: Place, b: Place): Place => ({ x: (a.x + b.x) / 2, y: (a.y + b.y) / 2 });
const distance = (a: Place, b: Place) => Math.max(1, Math.hypot(a.x - b.x, a.y - b.y));

const CLICK = 3; // pixels that a hand may move in a click

/** Moves the view's camera by what happens on its element, and calls `onPick` for Ctrl + click, until the function that is returned is called. */
export function listen(element: HTMLElement, view: View, onPick: () => void): () => void {
  const held = new Map<number, Place>();
  let motion: Motion | null = null;
  let pressed: Place = { x: 0, y: 0 };
  let hasMoved = false; // away from there

  function placeOf(event: MouseEvent): Place {
    const box = element.getBoundingClientRect();
    const pixels = devicePixelRatio;
    return { x: (event.clientX - box.left) * pixels, y: (box.bottom - event.clientY) * pixels };
  }

  function down(event: PointerEvent): void {
    if (held.size === 0) {
      motion = motionOf(event);
      hasMoved = false;
      view.under = pressed = placeOf(event);
    }
    if (motion === null || held.size === 2) return;
    element.focus();
    element.setPointerCapture(event.pointerId);
    held.set(event.pointerId, placeOf(event));
    event.preventDefault();
  }

  function move(event: PointerEvent): void {
    const from = held.get(event.pointerId);
    view.under = placeOf(event);
    if (!from || motion === null) return;
    const to = placeOf(event);
    hasMoved ||= distance(pressed, to) > CLICK;
    const other = [...held].find(([id]) => id !== event.pointerId)?.[1];
    held.set(event.pointerId, to);
    if (!other) {
      view[motion](from, to);
      return;
    }
    view.pan(middleOf(from, other), middleOf(to, other));
    view.wheel(Math.log(distance(to, other) / distance(from, other)) / (2 * Math.log(1.1)));
  }

  function up(event: PointerEvent): void {
    const isClick = held.delete(event.pointerId) && !hasMoved && event.type === 'pointerup';
    if (isClick && event.button === 0 && event.ctrlKey) onPick();
  }

  function wheel(event: WheelEvent): void {
    event.preventDefault();
    const notch = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? 100 : 3;
    view.wheel(-event.deltaY / notch);
  }

  const end = new AbortController();
  const { signal } = end;
  element.addEventListener('pointerdown', down, { signal });
  element.addEventListener('pointermove', move, { signal });
  element.addEventListener('pointerup', up, { signal });
  element.addEventListener('pointercancel', up, { signal });
  element.addEventListener('wheel', wheel, { signal, passive: false });
  element.addEventListener(
    'contextmenu',
    (event) => {
      event.preventDefault();
    },
    { signal },
  );
  return () => {
    end.abort();
  };
}
