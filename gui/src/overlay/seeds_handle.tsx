// SPDX-License-Identifier: Apache-2.0
// The box or the line of Seeds in the picture. Grips move the sides of the box, the box itself, and the ends of the line.
import type { KeyboardEvent } from 'react';
import type { Path } from '../graph/edits';
import type { Json } from '../graph/json';
import type { Box } from '../view/camera';
import { scale, type Vec3 } from '../view/vector';
import { stepsOf, useHand } from './hand';
import type { HandEdits } from './hand_edits';
import { diagonalOf, edgesOf, middleOf, motionAlong } from './plane';
import { type Point, project, projectLine, type Projection } from './projection';
import {
  boxJson,
  boxMoved,
  middleOfSide,
  motionInPicture,
  pointMoved,
  type SeedsNode,
  type Side,
  SIDES,
  shapeOf,
  withSideMoved,
} from './seeds';
import './seeds_handle.css';
import { useDomainBox } from './use_domain_box';

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
  const edges = shape.kind === 'box' ? edgesOf(shape.box) : [[shape.from, shape.to] as const];
  const path = edges
    .map(([from, to]) => projectLine(view, from, to))
    .map((line) => (line ? `M${line[0].x} ${line[0].y}L${line[1].x} ${line[1].y}` : ''))
    .join('');
  const unit = diagonalOf(box) / 100;
  const name = project(view, shape.kind === 'box' ? middleOf(shape.box) : shape.from);
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

function Grip({ at, label, hand }: { at: Point; label: string; hand: object }) {
  return <circle className="grip" tabIndex={0} aria-label={label} cx={at.x} cy={at.y} r={6} {...hand} />;
}
