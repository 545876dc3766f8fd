// SPDX-License-Identifier: Apache-2.0
// How a graph is fitted into the canvas so that the text of its cards can be read.
import { MARGIN, type Rect, type Size, type Viewport, inSight } from './room';

const LEAST_TEXT = 12; // pixels of text that can be read
const TEXT = 14; // of cards at zoom 1, in canvas.css
/** The least zoom at which it can be read. */
export const READABLE = LEAST_TEXT / TEXT;

/**
 * The whole graph in the canvas, if its text can be read then. Else it is as small as can be read, and `focus` is in sight; the other
 * cards are too, as far as there is room.
 */
export function readableViewport(graph: Rect, focus: Rect, canvas: Size): Viewport {
  const across = (canvas.width - 2 * MARGIN) / graph.width;
  const down = (canvas.height - 2 * MARGIN) / graph.height;
  const zoom = Math.max(READABLE, Math.min(1, across, down));
  const centred = {
    x: (canvas.width - graph.width * zoom) / 2 - graph.x * zoom,
    y: (canvas.height - graph.height * zoom) / 2 - graph.y * zoom,
    zoom,
  };
  return inSight(centred, canvas, focus);
}
