// SPDX-License-Identifier: Apache-2.0
// Two places side by side with a bar between them, which is dragged or moved by arrow keys.
import { type KeyboardEvent, type PointerEvent, type ReactNode, useRef, useState } from 'react';

interface SplitProps {
  direction: 'row' | 'column';
  /** What the bar changes, for screen readers. */
  name: string;
  /** The first place's part of the whole, 0 to 1. */
  initial: number;
  children: [ReactNode, ReactNode];
}

const LEAST = 0.1;
const STEP = 0.02;

export function Split({ direction, name, initial, children }: SplitProps) {
  const [part, setPart] = useState(initial);
  const whole = useRef<HTMLDivElement>(null);
  const row = direction === 'row';
  const set = (value: number) => {
    setPart(Math.min(1 - LEAST, Math.max(LEAST, value)));
  };

  function drag(event: PointerEvent) {
    if (!event.currentTarget.hasPointerCapture(event.pointerId) || !whole.current) return;
    const box = whole.current.getBoundingClientRect();
    set(row ? (event.clientX - box.left) / box.width : (event.clientY - box.top) / box.height);
  }

  function key(event: KeyboardEvent) {
    const by = { ArrowLeft: -STEP, ArrowUp: -STEP, ArrowRight: STEP, ArrowDown: STEP }[event.key];
    if (by === undefined) return;
    event.preventDefault();
    set(part + by);
  }

  return (
    <div ref={whole} className={`split split-${direction}`}>
      <div className="split-place" style={{ flexGrow: part }}>
        {children[0]}
      </div>
      <div
        className="split-bar"
        role="separator"
        tabIndex={0}
        aria-label={name}
        aria-orientation={row ? 'vertical' : 'horizontal'}
        aria-valuemin={LEAST * 100}
        aria-valuemax={100 - LEAST * 100}
        aria-valuenow={Math.round(part * 100)}
        onPointerDown={(event) => {
          event.currentTarget.setPointerCapture(event.pointerId);
        }}
        onPointerMove={drag}
        onKeyDown={key}
      />
      <div className="split-place" style={{ flexGrow: 1 - part }}>
        {children[1]}
      </div>
    </div>
  );
}
