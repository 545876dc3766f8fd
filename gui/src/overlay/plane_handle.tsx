// SPDX-License-Identifier: Apache-2.0
// A slice or a clip plane in the picture: its outline in the data's box, a grip that moves it along its normal, and an arrow that turns it.
import { type KeyboardEvent, useState } from 'react';
import type { Json } from '../graph/json';
import type { Box } from '../view/camera';
import { add, dot, scale, type Vec3 } from '../view/vector';
import { stepsOf, useHand } from './hand';
import type { HandEdits } from './hand_edits';
import type { PlaneOfLook } from './looks';
import {
  anchorOf,
  arrowAt,
  diagonalOf,
  motionAlong,
  movedBy,
  normalOf,
  normalTurned,
  outlineOf,
  type Plane,
  turnedTo,
  withinBox,
} from './plane';
import { pixelAt, type Point, project, projectLine, type Projection, rayAt } from './projection';

const REACH = 64; // pixels from the grip to the arrow's tip, as far as the arrow is not seen from its end
const APART = 20; // pixels that keep them apart then
const TURN = 5; // degrees by a key

export interface PlaneHandleProps {
  readonly of: PlaneOfLook;
  readonly view: Projection;
  readonly box: Box;
  readonly hands: HandEdits;
  readonly canEdit: boolean;
  readonly onLookAt: (point: Vec3, direction: Vec3) => void;
}

const json = (plane: Plane): Json => [...plane];

/** The outline of a plane in the box, as the data of a path. */
function outlinePath(view: Projection, box: Box, plane: Plane): string {
  const corners = outlineOf(plane, box);
  const lines =
    corners.length < 3 ? [] : corners.map((from, i) => [from, corners[(i + 1) % corners.length] ?? from]);
  return lines
    .map(([from, to]) => from && to && projectLine(view, from, to))
    .map((line) => (line ? `M${line[0].x} ${line[0].y}L${line[1].x} ${line[1].y}` : ''))
    .join('');
}

/** The outline of a plane that no hand moves. */
export function PlaneOutline({ of, view, box }: Pick<PlaneHandleProps, 'of' | 'view' | 'box'>) {
  const path = outlinePath(view, box, of.plane);
  return (
    <g className={`plane plane-${of.kind}`}>
      <path className="halo" d={path} />
      <path className="line" d={path} />
    </g>
  );
}

export function PlaneHandle(props: PlaneHandleProps) {
  const { of, view, box, canEdit } = props;
  const [held, setHeld] = useState<Vec3 | null>(null); // about which a hand turns the plane
  const anchor = held ?? anchorOf(of.plane, box);
  const path = outlinePath(view, box, of.plane);
  const at = project(view, anchor);
  return (
    <g className={`plane plane-${of.kind}`} data-plane={of.path.join('/')}>
      <path className="halo" d={path} />
      <path className="line" d={path} />
      {at && canEdit && <Grips {...{ ...props, anchor, at, path, setHeld }} />}
    </g>
  );
}

interface GripsProps extends PlaneHandleProps {
  readonly anchor: Vec3;
  readonly at: Point;
  readonly path: string; // of the outline
  readonly setHeld: (anchor: Vec3 | null) => void;
}

function Grips({ of, view, box, hands, onLookAt, anchor, at, path, setHeld }: GripsProps) {
  const { plane, label } = of;
  const normal = normalOf(plane);
  const reach = REACH * pixelAt(view, anchor);
  const tip = project(view, add(anchor, scale(normal, reach))) ?? at;
  const shownTip = apart(at, tip);

  function turn(to: Vec3): Plane {
    return turnedTo(plane, to, anchor, box);
  }
  function lookAt(): void {
    onLookAt(anchor, normal);
  }
  function slideByKey(event: KeyboardEvent): boolean {
    const steps = stepsOf(event);
    if (event.key === 'Enter') lookAt();
    else if (steps !== 0)
      hands.step(of.path, json(withinBox(movedBy(plane, (steps * diagonalOf(box)) / 100, box), box)));
    else return false;
    return true;
  }
  function turnByKey(event: KeyboardEvent): boolean {
    const degrees = TURN * stepsOf(event);
    const isSideways = event.key === 'ArrowLeft' || event.key === 'ArrowRight';
    if (event.key === 'Enter') lookAt();
    else if (degrees !== 0) {
      const turned = isSideways
        ? normalTurned(view, normal, degrees, 0)
        : normalTurned(view, normal, 0, degrees);
      hands.step(of.path, json(turn(turned)));
    } else return false;
    return true;
  }
  const slide = useHand(
    hands,
    of.path,
    (from) => (to) => json(withinBox(movedBy(plane, motionAlong(view, anchor, normal, from, to), box), box)),
    slideByKey,
  );
  const turning = useHand(
    hands,
    of.path,
    (from) => {
      setHeld(anchor);
      const isFront = dot(normal, rayAt(view, at).direction) <= 0;
      return (to) => {
        const place = { x: to.x + tip.x - from.x, y: to.y + tip.y - from.y };
        return json(turn(arrowAt(view, anchor, reach, place, isFront)));
      };
    },
    turnByKey,
    () => setHeld(null),
  );
  const ends = [-Infinity, Infinity].map((d) => withinBox([plane[0], plane[1], plane[2], d], box)[3]);
  return (
    <>
      <path className="hit" tabIndex={-1} d={path} onDoubleClick={lookAt} {...slide} />
      <path className="halo" d={`M${at.x} ${at.y}L${shownTip.x} ${shownTip.y}`} />
      <path className="arrow" d={`M${at.x} ${at.y}L${shownTip.x} ${shownTip.y}`} />
      <circle
        className="grip"
        role="slider"
        tabIndex={0}
        aria-label={`Move ${label} along its normal`}
        aria-valuenow={plane[3]}
        aria-valuemin={ends[0]}
        aria-valuemax={ends[1]}
        cx={at.x}
        cy={at.y}
        r={7}
        onDoubleClick={lookAt}
        {...slide}
      />
      <path
        className="grip"
        role="button"
        tabIndex={0}
        aria-label={`Look at ${label}; arrow keys turn it`}
        d={arrowHead(at, shownTip)}
        onDoubleClick={lookAt}
        {...turning}
      />
      <text className="name" x={at.x + 12} y={at.y + 16}>
        {of.name}
      </text>
    </>
  );
}

/** The tip, not so near to the grip that one covers the other. */
function apart(at: Point, tip: Point): Point {
  const [x, y] = [tip.x - at.x, tip.y - at.y];
  const distance = Math.hypot(x, y);
  if (distance >= APART) return tip;
  return distance < 1
    ? { x: at.x, y: at.y - APART }
    : { x: at.x + (x * APART) / distance, y: at.y + (y * APART) / distance };
}

/** A triangle at `tip` that points away from `from`. */
function arrowHead(from: Point, tip: Point): string {
  const distance = Math.hypot(tip.x - from.x, tip.y - from.y) || 1;
  const [x, y] = [(tip.x - from.x) / distance, (tip.y - from.y) / distance];
  const corner = (along: number, across: number): string =>
    `${tip.x + along * x - across * y} ${tip.y + along * y + across * x}`;
  return `M${corner(9, 0)}L${corner(-6, 8)}L${corner(-6, -8)}Z`;
}
