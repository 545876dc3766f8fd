// SPDX-License-Identifier: Apache-2.0
// The histogram with the curve of the opacities over it. Without such a curve it is the histogram alone.
import { useMemo, useRef } from 'react';
import { rounded } from '../panels/values';
import {
  type Scale,
  nudged,
  placeIn,
  placeOnScale,
  scaleTicks,
  stepIn,
  valueOnScale,
  valueTicks,
} from './axis';
import { Handle, placeOf } from './handle';
import { type Histogram, outline } from './histogram';
import type { LookMap } from './look_maps';
import { type Point, type Points, type Span, evaluate } from './points';
import { type PointsOfLook, handleId } from './use_points';

/** More points than this are a curve that nobody moves point by point. */
export const MOST_HANDLES = 48;

const [WIDTH, HEIGHT] = [1000, 100]; // of the drawing, which is stretched over its place

export const percent = (part: number): string => `${100 * part}%`;
export const numberText = (value: number): string => String(Number(value.toPrecision(5)));

function pathOf(corners: readonly Point[]): string {
  return corners
    .map(
      ([x, y], i) => `${i ? 'L' : 'M'}${(x * WIDTH).toFixed(2)} ${((1 - (y as number)) * HEIGHT).toFixed(2)}`,
    )
    .join('');
}

/** The corners of the curve. On a logarithmic axis what is straight between two points is bent. */
function curve(points: Points, domain: Span, scale: Scale): Point[] {
  const at = ([value, opacity]: Point): Point => [
    placeIn(domain, value),
    placeOnScale(scale, opacity as number),
  ];
  const between = points.flatMap((point, i): Point[] => {
    const before = points[i - 1];
    if (!scale.isLog || !before || before[0] === point[0]) return [point];
    return Array.from({ length: 32 }, (_, k): Point => {
      const value = before[0] + ((point[0] - before[0]) * (k + 1)) / 32;
      return k === 31 ? point : [value, ...evaluate([before, point], value)];
    });
  });
  const ends = (value: number): Point => [value, ...evaluate(points, value)];
  const [low, high] = [points[0] as Point, points[points.length - 1] as Point];
  return [
    ...(low[0] > domain[0] ? [ends(domain[0])] : []),
    ...between,
    ...(high[0] < domain[1] ? [ends(domain[1])] : []),
  ].map(at);
}

interface PlotProps {
  readonly map: LookMap | undefined;
  readonly what: string; // "opacity" or "extinction"
  readonly histogram: Histogram | undefined;
  readonly isLogCounts: boolean;
  readonly domain: Span;
  readonly scale: Scale;
  readonly points: PointsOfLook;
  readonly onHold: (isHeld: boolean) => void;
}

export function Plot(props: PlotProps) {
  const { map, what, histogram, isLogCounts, domain, scale, points, onHold } = props;
  const area = useRef<HTMLDivElement>(null);
  const bars = useMemo(
    () => (histogram ? pathOf(outline(histogram, domain, isLogCounts)) : ''),
    [histogram, domain, isLogCounts],
  );
  const shown = map?.points;
  const step = stepIn(domain);
  const valueAt = (x: number): number => rounded(domain[0] + (domain[1] - domain[0]) * x, step);

  const handles = map && shown && shown.length <= MOST_HANDLES ? shown : [];
  return (
    <div className="map-plot">
      <div className="map-scale" aria-hidden>
        {map &&
          scaleTicks(scale).map((t) => (
            <span key={t} style={{ bottom: percent(placeOnScale(scale, t)) }}>
              {numberText(t)}
            </span>
          ))}
      </div>
      <div
        ref={area}
        className="map-area"
        onDoubleClick={(event) => {
          const [x, y] = placeOf(area.current, event);
          if (map && shown) points.add(map, shown, [valueAt(x), valueOnScale(scale, y)]);
        }}
      >
        <svg viewBox={`0 0 ${WIDTH} ${HEIGHT}`} preserveAspectRatio="none" aria-hidden>
          {map &&
            scaleTicks(scale).map((t) => (
              <line
                key={t}
                className="map-grid"
                x2={WIDTH}
                y1={HEIGHT * (1 - placeOnScale(scale, t))}
                y2={HEIGHT * (1 - placeOnScale(scale, t))}
              />
            ))}
          <path className="map-histogram" d={bars} />
          {shown && map && <path className="map-curve" d={pathOf(curve(shown, domain, scale))} />}
        </svg>
        {map &&
          handles.map((point, i) => {
            const [value, height] = point as unknown as readonly [number, number];
            const place = [placeIn(domain, value), placeOnScale(scale, height)] as const;
            return (
              <Handle
                key={i}
                id={handleId('opacity', i)}
                className="map-opacity"
                label={`Point ${i + 1} of ${handles.length}: value ${numberText(value)}, ${what} ${numberText(height)}`}
                style={{ left: percent(place[0]), bottom: percent(place[1]) }}
                isSelected={points.selected?.kind === 'opacity' && points.selected.place === i}
                {...{ area, place }}
                onSelect={() => points.select('opacity', i)}
                onBegin={() => {
                  onHold(true);
                  points.begin(map);
                }}
                // What the hand does not move keeps its digits.
                onMove={([x, y]) =>
                  points.move(map, i, ([was, high]) => [
                    Math.abs(x - placeIn(domain, was)) * WIDTH < 2 ? was : valueAt(x),
                    Math.abs(y - placeOnScale(scale, high as number)) * HEIGHT < 0.5
                      ? (high as number)
                      : valueOnScale(scale, y),
                  ])
                }
                onEnd={() => {
                  points.end(map);
                  onHold(false);
                }}
                onStep={(right, up) =>
                  points.nudge(map, i, [
                    right === 0 ? value : rounded(value + right * step, step),
                    up === 0 ? height : nudged(scale, height, up),
                  ])
                }
                onRemove={() => points.remove(map, i)}
              />
            );
          })}
      </div>
    </div>
  );
}

/** The numbers below the plot and the colours. */
export function ValueTicks({ domain }: { readonly domain: Span }) {
  return (
    <div className="map-values" aria-hidden>
      {valueTicks(domain).map((t) => (
        <span key={t} style={{ left: percent(placeIn(domain, t)) }}>
          {numberText(t)}
        </span>
      ))}
    </div>
  );
}
