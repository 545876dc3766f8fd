// SPDX-License-Identifier: Apache-2.0
// A point of a map as something that a hand or a key moves.
import { type CSSProperties, type KeyboardEvent, type PointerEvent, type RefObject, useRef } from 'react';

/** Where a hand is in an area: from its left and from its lower edge, 0 to 1. */
export type Place = readonly [x: number, y: number];

export interface HandleProps {
  readonly id: string;
  readonly className: string;
  readonly label: string;
  readonly style: CSSProperties;
  readonly isSelected: boolean;
  readonly area: RefObject<HTMLElement | null>;
  readonly place: Place; // of the point in the area
  readonly onSelect: () => void;
  readonly onBegin: () => void;
  readonly onMove: (to: Place) => void;
  readonly onEnd: () => void;
  /** Steps of the arrow keys, ten times as long with Shift. */
  readonly onStep: (right: number, up: number) => void;
  readonly onRemove: () => void;
}

export function placeOf(area: HTMLElement | null, event: { clientX: number; clientY: number }): Place {
  const box = area?.getBoundingClientRect();
  if (!box || box.width === 0 || box.height === 0) return [0, 0];
  return [(event.clientX - box.left) / box.width, 1 - (event.clientY - box.top) / box.height];
}

const STEPS: Readonly<Record<string, readonly [number, number]>> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, 1],
  ArrowDown: [0, -1],
};

export function Handle(props: HandleProps) {
  const { area, place, onBegin, onMove, onEnd, onSelect } = props;
  // Where the hand took hold, beside the point's middle; undefined while it holds nothing.
  const held = useRef<{ readonly off: Place; readonly from: Place; isMoved: boolean }>(undefined);

  function down(event: PointerEvent<HTMLButtonElement>): void {
    if (event.button !== 0) return;
    event.currentTarget.setPointerCapture(event.pointerId);
    const from = placeOf(area.current, event);
    held.current = { off: [place[0] - from[0], place[1] - from[1]], from, isMoved: false };
    onSelect();
  }
  function move(event: PointerEvent): void {
    const { current } = held;
    if (!current) return;
    const at = placeOf(area.current, event);
    if (!current.isMoved && at[0] === current.from[0] && at[1] === current.from[1]) return;
    if (!current.isMoved) onBegin();
    current.isMoved = true;
    onMove([at[0] + current.off[0], at[1] + current.off[1]]);
  }
  function up(): void {
    if (held.current?.isMoved) onEnd();
    held.current = undefined;
  }
  function key(event: KeyboardEvent): void {
    const step = STEPS[event.key];
    const times = event.shiftKey ? 10 : 1;
    if (step) props.onStep(step[0] * times, step[1] * times);
    else if (event.key === 'Delete' || event.key === 'Backspace') props.onRemove();
    else return;
    event.preventDefault();
    event.stopPropagation(); // The canvas would remove the node.
  }
  return (
    <button
      type="button"
      id={props.id}
      className={`map-handle ${props.className}${props.isSelected ? ' selected' : ''}`}
      aria-label={props.label}
      aria-pressed={props.isSelected}
      style={props.style}
      onPointerDown={down}
      onPointerMove={move}
      onPointerUp={up}
      onPointerCancel={up}
      onFocus={onSelect}
      onKeyDown={key}
      onDoubleClick={(event) => event.stopPropagation()}
    />
  );
}
