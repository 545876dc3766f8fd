// SPDX-License-Identifier: Apache-2.0
// The box, the sphere or the line of Seeds in the picture. Grips move the sides of the box, the box itself, the middle of the sphere and
// its radius, and the ends of the line.
import type { KeyboardEvent } from 'react';
import type { Path } from '../graph/edits';
import type { Json } from '../graph/json';
import type { Box } from '../view/camera';
import { add, scale, type Vec3 } from '../view/vector';
import { stepsOf, useHand } from './hand';
import type { HandEdits } from './hand_edits';
import { diagonalOf, middleOf, motionAlong } from './plane';
import { pixelAt, type Point, project, projectLine, type Projection } from './projection';
import {
  boxJson,
  boxMoved,
  linesOf,
  middleOfSide,
  motionInPicture,
  pointMoved,
  radiusMoved,
  type SeedsNode,
  type SeedsShape,
  type Side,
  SIDES,
  shapeOf,
  withSideMoved,
} from './seeds';
import './seeds_handle.css';
import { useDomainBox } from './use_domain_box';

const APART = 20; // pixels between the middle of a sphere and the grip of its radius, at least
const AXES = ['x', 'y', 'z'] as const;
const UNITS: readonly Vec3[] = [
  [1, 0, 0],
  [0, 1, 0],
  [0, 0, 1],
];

export interface SeedsHandleProps {
  readonly of: SeedsNode;
  readonly view: Projection;
  /** Of the data in the picture: a step by a key is a hundredth of its diagonal. */
  readonly box: Box;
  readonly hands: HandEdits;
  readonly canEdit: boolean;
}

export function SeedsHandle(props: SeedsHandleProps) {
  const { of, view, box, canEdit } = props;
  const shape = shapeOf(of.entry, useDomainBox(of.domain));
  if (!shape) return null;
  const path = linesOf(shape)
    .map(([from, to]) => projectLine(view, from, to))
    .map((line) => (line ? `M${line[0].x} ${line[0].y}L${line[1].x} ${line[1].y}` : ''))
    .join('');
  const unit = diagonalOf(box) / 100;
  const name = project(view, anchorOf(shape));
  return (
    <g className="seeds" data-seeds={of.name}>
      <path className="halo" d={path} />
      <path className="line" d={path} />
      {canEdit && shape.kind === 'box' && (
        <>
          <PointGrip
            {...{ ...props, unit, point: middleOf(shape.box), path: [...of.path, 'box'] }}
            label={`Move the box of ${of.name}`}
            moved={(by) => boxJson(boxMoved(shape.box, by, unit / 100))}
          />
          {SIDES.map((side) => (
            <SideGrip
              key={`${side.axis} ${side.end}`}
              {...{ ...props, unit, side, seeds: shape.box, path: [...of.path, 'box'] }}
            />
          ))}
        </>
      )}
      {canEdit && shape.kind === 'sphere' && (
        <>
          <PointGrip
            {...{ ...props, unit, point: shape.center, path: [...of.path, 'center'] }}
            label={`Move the sphere of ${of.name}`}
            moved={(by) => [...pointMoved(shape.center, by, unit / 100)]}
          />
          <RadiusGrip
            {...{ ...props, unit, path: [...of.path, 'radius'] }}
            center={shape.center}
            radius={shape.radius}
          />
        </>
      )}
      {canEdit && shape.kind === 'line' && (
        <>
          {(['from', 'to'] as const).map((key) => (
            <PointGrip
              key={key}
              {...{ ...props, unit, point: shape[key], path: [...of.path, key] }}
              label={`Move ${key === 'from' ? 'the first' : 'the last'} point of ${of.name}`}
              moved={(by) => [...pointMoved(shape[key], by, unit / 100)]}
            />
          ))}
        </>
      )}
      {name && (
        <text className="name" x={name.x + 12} y={name.y + 16}>
          {of.name}
        </text>
      )}
    </g>
  );
}

/** Where the shape's name stands. */
function anchorOf(shape: SeedsShape): Vec3 {
  if (shape.kind === 'box') return middleOf(shape.box);
  return shape.kind === 'sphere' ? shape.center : shape.from;
}

interface GripProps extends SeedsHandleProps {
  readonly unit: number; // what a key moves it by
  readonly path: Path;
}

/** A point that follows the hand in the plane of the picture. */
function PointGrip(
  props: GripProps & {
    readonly point: Vec3;
    readonly label: string;
    readonly moved: (by: Vec3) => Json;
  },
) {
  const { view, hands, unit, path, point, label, moved } = props;
  function byKey(event: KeyboardEvent): boolean {
    const steps = stepsOf(event);
    if (steps === 0) return false;
    const isSideways = event.key === 'ArrowLeft' || event.key === 'ArrowRight';
    hands.step(path, moved(scale(isSideways ? view.right : view.up, steps * unit)));
    return true;
  }
  const hand = useHand(hands, path, (from) => (to) => moved(motionInPicture(view, point, from, to)), byKey);
  const at = project(view, point);
  return at && <Grip at={at} label={label} hand={{ role: 'button', ...hand }} />;
}

/** A side of the box, which moves along its axis. */
function SideGrip({
  of,
  view,
  hands,
  unit,
  path,
  side,
  seeds,
}: GripProps & { readonly side: Side; readonly seeds: Box }) {
  const { axis, end } = side;
  const point = middleOfSide(seeds, side);
  const along = UNITS[axis] as Vec3;
  const moved = (by: number): Json => boxJson(withSideMoved(seeds, side, by, unit / 100));
  function byKey(event: KeyboardEvent): boolean {
    const steps = stepsOf(event);
    if (steps !== 0) hands.step(path, moved(steps * unit));
    return steps !== 0;
  }
  const hand = useHand(
    hands,
    path,
    (from) => (to) => moved(motionAlong(view, point, along, from, to)),
    byKey,
  );
  const at = project(view, point);
  const label = `Move the ${end === 0 ? 'lower' : 'upper'} ${AXES[axis]} side of ${of.name}`;
  const value = { role: 'slider', 'aria-valuenow': seeds[end][axis] };
  return at && <Grip at={at} label={label} hand={{ ...value, ...hand }} />;
}

/** The point of the sphere that is right of its middle in the picture. It moves to the side, and the radius with it. */
function RadiusGrip({
  of,
  view,
  hands,
  unit,
  path,
  center,
  radius,
}: GripProps & { readonly center: Vec3; readonly radius: number }) {
  const moved = (by: number): Json => radiusMoved(radius, by, unit / 100);
  function byKey(event: KeyboardEvent): boolean {
    const steps = stepsOf(event);
    if (steps !== 0) hands.step(path, moved(steps * unit));
    return steps !== 0;
  }
  const hand = useHand(
    hands,
    path,
    (from) => (to) => moved(motionAlong(view, center, view.right, from, to)),
    byKey,
  );
  const away = Math.max(radius, APART * pixelAt(view, center));
  const at = project(view, add(center, scale(view.right, away)));
  const value = { role: 'slider', 'aria-valuenow': radius, 'aria-valuemin': 0 };
  return at && <Grip at={at} label={`Change the radius of ${of.name}`} hand={{ ...value, ...hand }} />;
}

function Grip({ at, label, hand }: { at: Point; label: string; hand: object }) {
  return <circle className="grip" tabIndex={0} aria-label={label} cx={at.x} cy={at.y} r={6} {...hand} />;
}
