// SPDX-License-Identifier: Apache-2.0
// Where a new card has room, and how far the canvas is moved so that cards are in sight.
import type { Position } from '../graph/changes';

export interface Size {
  readonly width: number;
  readonly height: number;
}
export interface Rect extends Size {
  readonly x: number;
  readonly y: number;
}
/** Where the canvas' origin is, in pixels, and the pixels of its unit. */
export interface Viewport {
  readonly x: number;
  readonly y: number;
  readonly zoom: number;
}

const GAP = 28; // between cards
export const MARGIN = 12; // pixels between cards and the edge of the canvas

function isFree(card: Rect, others: readonly Rect[]): boolean {
  const least = GAP - 0.5; // Sums of fractions are not exact.
  return others.every(
    (other) =>
      card.x >= other.x + other.width + least ||
      other.x >= card.x + card.width + least ||
      card.y >= other.y + other.height + least ||
      other.y >= card.y + card.height + least,
  );
}

/** The place nearest to `wanted`, straight above or below it, where a card of a size does not touch others. */
export function placeWithRoom([x, y]: Position, size: Size, others: readonly Rect[]): Position {
  const heights = [y, ...others.flatMap((o) => [o.y + o.height + GAP, o.y - size.height - GAP])];
  const free = heights.filter((at) => isFree({ ...size, x, y: at }, others));
  const nearest = free.reduce((best, at) => (Math.abs(at - y) < Math.abs(best - y) ? at : best), Infinity);
  return [x, nearest];
}

/** A place below all others. */
export function placeBelow(others: readonly Rect[]): Position {
  return others.length === 0 ? [0, 0] : [0, Math.max(...others.map((o) => o.y + o.height)) + GAP];
}

/** The smallest rectangle around all; null: there are none. */
export function boundsOf(cards: readonly Rect[]): Rect | null {
  if (cards.length === 0) return null;
  const [x, y] = [Math.min(...cards.map((c) => c.x)), Math.min(...cards.map((c) => c.y))];
  return {
    ...{ x, y },
    width: Math.max(...cards.map((c) => c.x + c.width)) - x,
    height: Math.max(...cards.map((c) => c.y + c.height)) - y,
  };
}

/** The canvas, moved no further than needed to show a rectangle. Of one that is larger than the canvas, its lower right part is shown. */
export function inSight(viewport: Viewport, canvas: Size, rect: Rect): Viewport {
  const shifted = (origin: number, from: number, length: number, room: number): number => {
    const start = from * viewport.zoom + origin;
    const end = start + length * viewport.zoom;
    const after = start < MARGIN ? origin + MARGIN - start : origin;
    const over = end + (after - origin) - (room - MARGIN);
    return over > 0 ? after - over : after;
  };
  return {
    x: shifted(viewport.x, rect.x, rect.width, canvas.width),
    y: shifted(viewport.y, rect.y, rect.height, canvas.height),
    zoom: viewport.zoom,
  };
}
