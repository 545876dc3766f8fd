// SPDX-License-Identifier: Apache-2.0
// Which point of the maps is selected, and what hands and keys do to it.
import { useEffect, useRef, useState } from 'react';
import { useGraphStore } from '../canvas/graph_store';
import { equal, type Json } from '../graph/json';
import type { GraphNode } from '../graph/nodes';
import type { LookMap, LookMaps, MapKind } from './look_maps';
import { setPoints } from './look_maps';
import { type Point, type Points, withPoint, withPointAt, withoutPoint } from './points';

export interface Selected {
  readonly kind: MapKind;
  readonly place: number;
}

export const handleId = (kind: MapKind, place: number): string => `map ${kind} ${place}`;

let gestures = 0;

export function usePoints(node: GraphNode, maps: LookMaps) {
  const session = useGraphStore((s) => s.session);
  const [selected, setSelected] = useState<Selected>();
  const [message, setMessage] = useState('');
  const drag = useRef<{ readonly from: Points; readonly gesture: string; to: Points }>(undefined);
  const keys = useRef(''); // the gesture of the arrow keys, for the point that has the focus
  const focus = useRef(''); // the handle that gets the focus when it is there
  const isLive = useRef(''); // the gesture of which live edits were sent last

  useEffect(() => {
    if (focus.current === '') return;
    document.getElementById(focus.current)?.focus();
    focus.current = '';
  });

  function change(map: LookMap, points: Points, gesture = '', live = false): void {
    setMessage('');
    if (equal(points as unknown as Json, map.points as unknown as Json) && isLive.current !== gesture) return;
    isLive.current = live ? gesture : '';
    session?.edit([setPoints(node, map, points)], { live, ...(gesture === '' ? {} : { gesture }) });
  }
  const isEnd = (points: Points, place: number): boolean => place === 0 || place === points.length - 1;

  /** A point elsewhere. The ends of maps that are stretched over a range stay on the range's. */
  function put(from: Points, place: number, to: Point): Points {
    const kept = maps.range && isEnd(from, place) ? (from[place] as Point)[0] : to[0];
    return withPointAt(from, place, [kept, ...to.slice(1)]);
  }
  return {
    selected,
    message,
    say: setMessage,
    select(kind: MapKind, place: number): void {
      if (selected?.kind === kind && selected.place === place) return;
      keys.current = `map keys ${++gestures}`;
      setSelected({ kind, place });
    },
    change,
    begin(map: LookMap): void {
      if (map.points) drag.current = { from: map.points, to: map.points, gesture: `map drag ${++gestures}` };
    },
    move(map: LookMap, place: number, to: (from: Point) => Point): void {
      const { current } = drag;
      if (!current) return;
      current.to = put(current.from, place, to(current.from[place] as Point));
      change(map, current.to, current.gesture, true);
    },
    end(map: LookMap): void {
      if (drag.current) change(map, drag.current.to, drag.current.gesture);
      drag.current = undefined;
    },
    /** Once, or with a gesture as one of several changes that are one step for undo. */
    set(map: LookMap, place: number, to: Point, gesture = '', live = false): void {
      if (map.points) change(map, put(map.points, place, to), gesture, live);
    },
    /** By arrow keys: all for a point that keeps the focus are one step for undo. */
    nudge(map: LookMap, place: number, to: Point): void {
      if (map.points) change(map, put(map.points, place, to), keys.current);
    },
    add(map: LookMap, points: Points, point: Point): void {
      const range = maps.range;
      const value = range ? Math.min(range[1], Math.max(range[0], point[0])) : point[0];
      let [next, place] = withPoint(points, [value, ...point.slice(1)]);
      if (range && place === points.length)
        [next, place] = [withPointBeforeEnd(points, value, point), place - 1];
      change(map, next);
      setSelected({ kind: map.kind, place });
      focus.current = handleId(map.kind, place);
    },
    remove(map: LookMap, place: number): void {
      const { points } = map;
      if (!points || points.length < 2) return setMessage('A map has one point at least.');
      if (maps.range && isEnd(points, place))
        return setMessage('The ends of a map lie on the ends of its range, and stay.');
      change(map, withoutPoint(points, place));
      const next = Math.min(place, points.length - 2);
      setSelected({ kind: map.kind, place: next });
      focus.current = handleId(map.kind, next);
    },
  };
}

/** A point on the upper end of the range comes before the point that lies there. */
function withPointBeforeEnd(points: Points, value: number, [, ...what]: Point): Points {
  return [...points.slice(0, -1), [value, ...what], ...points.slice(-1)];
}

export type PointsOfLook = ReturnType<typeof usePoints>;
