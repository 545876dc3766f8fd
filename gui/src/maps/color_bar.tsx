// SPDX-License-Identifier: Apache-2.0
// The colours of a map as a bar, with the points that they are made of.
import { useId, useMemo, useRef } from 'react';
import type { Json } from '../graph/json';
import { hexOf, rounded } from '../panels/values';
import { placeIn, stepIn } from './axis';
import { Handle, placeOf } from './handle';
import type { LookMap } from './look_maps';
import { MOST_HANDLES, numberText, percent } from './plot';
import { type Points, type Span, evaluate, simplified } from './points';
import { type PointsOfLook, handleId } from './use_points';

export const colorText = (rgb: readonly number[]): string => hexOf(rgb as unknown as Json);

/** A picture of colours over a domain of values. */
export function Gradient({ points, domain }: { readonly points: Points; readonly domain: Span }) {
  const id = useId();
  const stops = useMemo(() => (points.length > 256 ? simplified(points, 1 / 255) : points), [points]);
  return (
    <svg className="map-gradient" viewBox="0 0 1000 10" preserveAspectRatio="none" aria-hidden>
      <linearGradient id={id} gradientUnits="userSpaceOnUse" x1="0" x2="1000">
        {stops.map(([value, ...rgb], i) => (
          <stop key={i} offset={placeIn(domain, value)} stopColor={colorText(rgb)} />
        ))}
      </linearGradient>
      <rect width="1000" height="10" fill={`url(#${id})`} />
    </svg>
  );
}

/** A map with so few points that each can be moved, and what it says nearly unchanged. */
export function fewPoints(points: Points): Points {
  for (let tolerance = 1 / 255; ; tolerance *= 2) {
    const few = simplified(points, tolerance);
    if (few.length <= MOST_HANDLES) return few;
  }
}

interface ColorBarProps {
  readonly map: LookMap;
  readonly domain: Span;
  readonly points: PointsOfLook;
  readonly onHold: (isHeld: boolean) => void;
}

export function ColorBar({ map, domain, points, onHold }: ColorBarProps) {
  const area = useRef<HTMLDivElement>(null);
  const { points: shown } = map;
  const step = stepIn(domain);
  const valueAt = (x: number): number => rounded(domain[0] + (domain[1] - domain[0]) * x, step);
  if (!shown) return null;
  const handles = map.name === '' && shown.length <= MOST_HANDLES ? shown : [];
  return (
    <div
      ref={area}
      className="map-colors"
      onDoubleClick={(event) => {
        const value = valueAt(placeOf(area.current, event)[0]);
        const before = handles.length > 0 ? shown : fewPoints(shown);
        points.add(map, before, [value, ...evaluate(shown, value).map((c) => Number(c.toFixed(4)))]);
      }}
    >
      <Gradient points={shown} domain={domain} />
      {handles.map(([value, ...rgb], i) => (
        <Handle
          key={i}
          id={handleId('color', i)}
          className="map-color"
          label={`Colour ${i + 1} of ${handles.length}: value ${numberText(value)}, ${colorText(rgb)}`}
          style={{ left: percent(placeIn(domain, value)), backgroundColor: colorText(rgb) }}
          isSelected={points.selected?.kind === 'color' && points.selected.place === i}
          area={area}
          place={[placeIn(domain, value), 0]}
          onSelect={() => points.select('color', i)}
          onBegin={() => {
            onHold(true);
            points.begin(map);
          }}
          onMove={([x]) => points.move(map, i, ([, ...color]) => [valueAt(x), ...color])}
          onEnd={() => {
            points.end(map);
            onHold(false);
          }}
          onStep={(right) =>
            points.nudge(map, i, [right === 0 ? value : rounded(value + right * step, step), ...rgb])
          }
          onRemove={() => points.remove(map, i)}
        />
      ))}
    </div>
  );
}
