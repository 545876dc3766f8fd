// SPDX-License-Identifier: Apache-2.0
// What the page shows over a picture, as one drawing that nothing can be done with.
import { printable } from '../app/foreign';
import type { ShippedMap } from '../maps/colormaps';
import { barHeightIn, firstLegend, type Legend } from '../overlay/legend';
import { isovaluesText, LegendScale, MARGIN, StillMark, WIDTH } from '../overlay/legend_panel';
import { type IsovalueOfLook, isovaluesOf, type Look, planesOf } from '../overlay/looks';
import { AxesMark, BoxMark, PickMark } from '../overlay/marks';
import type { OverlayName } from '../overlay/overlay_state';
import { PlaneOutline } from '../overlay/plane_handle';
import { projectionOf } from '../overlay/projection';
import type { Size } from '../view/camera';
import type { Seen } from '../view/remote_window';
import type { Vec3 } from '../view/vector';

export interface Drawn {
  readonly seen: Seen;
  /** Of the drawing, in pixels of the page: what they span of the picture is the same as on the page. */
  readonly size: Size;
  readonly shown: Readonly<Record<OverlayName, boolean>>;
  readonly looks: readonly Look[];
  readonly shipped: readonly ShippedMap[];
  readonly picked: Vec3 | null;
}

export function OverlayDrawing({ seen, size, shown, looks, shipped, picked }: Drawn) {
  const view = projectionOf(seen.camera, size);
  const { box } = seen;
  const height = barHeightIn(size);
  const first = shown.legend && height !== null ? firstLegend(looks, seen.ranges, shipped) : null;
  return (
    <svg xmlns="http://www.w3.org/2000/svg" viewBox={`0 0 ${size.width} ${size.height}`}>
      {shown.box && box && <BoxMark view={view} box={box} />}
      {shown.axes && <AxesMark view={view} />}
      {picked && <PickMark view={view} point={picked} />}
      {shown.handles &&
        box &&
        looks
          .flatMap(planesOf)
          .map((of) => <PlaneOutline key={of.path.join('/')} of={of} view={view} box={box} />)}
      {first && height !== null && (
        <LegendDrawing
          legend={first.legend}
          isovalues={isovaluesOf(first.look)}
          height={height}
          right={size.width - 8}
        />
      )}
    </svg>
  );
}

const LINE = 17; // pixels of a line of text
const PADDING = { x: 7, y: 4 };

interface LegendDrawingProps {
  readonly legend: Legend;
  readonly isovalues: readonly IsovalueOfLook[];
  readonly height: number;
  readonly right: number;
}

function LegendDrawing({ legend, isovalues, height, right }: LegendDrawingProps) {
  const title = printable(legend.title);
  const note = isovalues.length > 0 ? isovaluesText(isovalues) : '';
  const inner = Math.min(right - 16, Math.max(WIDTH, widthOf(title), widthOf(note)));
  const below = LINE + height + 2 * MARGIN;
  const whole = { width: inner + 2 * PADDING.x, height: below + (note ? LINE : 0) + 2 * PADDING.y };
  return (
    <g className="legend" transform={`translate(${right - whole.width} 8)`}>
      <rect className="legend-panel" rx={4} {...whole} />
      <text x={PADDING.x} y={PADDING.y + 12}>
        {title}
      </text>
      <g transform={`translate(${PADDING.x} ${PADDING.y + LINE})`}>
        <LegendScale {...{ legend, height, id: 'legend-colors' }} />
        {isovalues.map((of) => (
          <StillMark key={of.path.join('/')} {...{ of, legend, height }} />
        ))}
      </g>
      {note && (
        <text className="note" x={PADDING.x} y={PADDING.y + below + 12}>
          {note}
        </text>
      )}
    </g>
  );
}

/** The width of a text of the legend. */
function widthOf(text: string): number {
  const pen = new OffscreenCanvas(1, 1).getContext('2d');
  if (!pen) return 0;
  pen.font = `12px ${getComputedStyle(document.body).fontFamily}`;
  return pen.measureText(text).width;
}
