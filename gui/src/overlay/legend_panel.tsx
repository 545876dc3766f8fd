// SPDX-License-Identifier: Apache-2.0
// The colour legend of a look. Marks at its isovalues can be dragged, and moved by arrow keys.
import { type KeyboardEvent, useId } from 'react';
import { Foreign } from '../app/foreign';
import { stepsOf, useHand } from './hand';
import type { HandEdits } from './hand_edits';
import { hexOf, type Legend, numberTexts, placeOnLegend, roundNumbers } from './legend';
import type { IsovalueOfLook } from './looks';
import { roundedTo } from './plane';

export const WIDTH = 114; // for nine digits and a point
const BAR = { x: 20, width: 14 };
export const MARGIN = 8; // above and below the bar, for half a line of text
const LINE = 16; // pixels that a number needs

interface LegendPanelProps {
  readonly legend: Legend;
  readonly isovalues: readonly IsovalueOfLook[];
  /** Of the bar, in pixels. */
  readonly height: number;
  readonly hands: HandEdits;
  readonly canEdit: boolean;
}

export function LegendPanel({ legend, isovalues, height, hands, canEdit }: LegendPanelProps) {
  const id = useId();
  return (
    <div className="legend" role="group" aria-label={`Legend of ${legend.title}`}>
      <p>
        <Foreign text={legend.title} />
      </p>
      <svg width={WIDTH} height={height + 2 * MARGIN}>
        <LegendScale {...{ legend, height, id }} />
        {isovalues.map((of) => (
          <IsovalueMark
            key={of.path.join('/')}
            {...{ of, legend, height, hands, canEdit, y: placeIn(legend, height, of.value) }}
          />
        ))}
      </svg>
      {isovalues.length > 0 && <p className="weak">{isovaluesText(isovalues)}</p>}
    </div>
  );
}

/** For people. */
export const isovaluesText = (isovalues: readonly IsovalueOfLook[]): string =>
  `at ${isovalues.map(({ value }) => value).join(', ')}`;

/** The place of a value, in pixels from the upper end of the legend's margin. */
function placeIn(legend: Legend, height: number, value: number): number {
  return MARGIN + (1 - placeOnLegend(legend, value)) * height;
}

interface LegendScaleProps {
  readonly legend: Legend;
  readonly height: number;
  /** Of its gradient, unique in the document. */
  readonly id: string;
}

/** The bar of colours, and numbers beside it. */
export function LegendScale({ legend, height, id }: LegendScaleProps) {
  const numbers = ticksOf(legend, height);
  const texts = numberTexts(numbers, legend.range[1] - legend.range[0]);
  return (
    <>
      <ColorBar {...{ legend, height, id }} />
      {numbers.map((number, i) => {
        const y = placeIn(legend, height, number);
        return (
          <g key={number}>
            <path className="tick" d={`M${BAR.x + BAR.width} ${y}h4`} />
            <text x={BAR.x + BAR.width + 7} y={y + 4}>
              {texts[i]}
            </text>
          </g>
        );
      })}
    </>
  );
}

/** Round numbers, so few that they do not touch, and the ends where no round number is near. */
function ticksOf({ range }: Legend, height: number): readonly number[] {
  const room = ((range[1] - range[0]) * LINE) / height;
  let numbers = roundNumbers(range);
  while (numbers.length > 1 && (numbers[1] ?? 0) - (numbers[0] ?? 0) < room)
    numbers = numbers.filter((_, i) => i % 2 === 0);
  const [first = Infinity, last = -Infinity] = [numbers[0], numbers[numbers.length - 1]];
  return [
    ...(first - range[0] > room ? [range[0]] : []),
    ...numbers,
    ...(range[1] - last > room ? [range[1]] : []),
  ];
}

function ColorBar({ legend, height, id }: { legend: Legend; height: number; id: string }) {
  const { colors } = legend;
  const box = { x: BAR.x, y: MARGIN, width: BAR.width, height };
  return (
    <>
      <linearGradient id={id} x1={0} y1={1} x2={0} y2={0}>
        {colors.map((point, i) => (
          <stop key={i} offset={placeOnLegend(legend, point[0])} stopColor={hexOf(point)} />
        ))}
      </linearGradient>
      <rect className="bar" fill={colors.length > 0 ? `url(#${id})` : 'none'} {...box} />
    </>
  );
}

const shapeOf = (y: number): string => `M${BAR.x - 1} ${y}l-14 -7v14z`;

const isBeyond = ({ value }: IsovalueOfLook, { range: [lo, hi] }: Legend): boolean =>
  value < lo || value > hi;

interface StillMarkProps {
  readonly of: IsovalueOfLook;
  readonly legend: Legend;
  readonly height: number;
}

/** The mark of an isovalue that no hand moves. */
export function StillMark({ of, legend, height }: StillMarkProps) {
  const name = isBeyond(of, legend) ? 'mark mark-beyond' : 'mark';
  return <path className={name} d={shapeOf(placeIn(legend, height, of.value))} />;
}

interface MarkProps {
  readonly of: IsovalueOfLook;
  readonly legend: Legend;
  readonly height: number;
  readonly hands: HandEdits;
  readonly canEdit: boolean;
  readonly y: number;
}

/** A triangle at the bar. It is hollow where the value lies beyond the legend's end. */
function IsovalueMark({ of, legend, height, hands, canEdit, y }: MarkProps) {
  const [lo, hi] = legend.range;
  const span = hi - lo;
  const valid = (value: number): number => roundedTo(Math.min(hi, Math.max(lo, value)), span / 1000);
  function byKey(event: KeyboardEvent): boolean {
    const steps = stepsOf(event);
    if (event.key === 'Home') hands.step(of.path, valid(lo));
    else if (event.key === 'End') hands.step(of.path, valid(hi));
    else if (steps !== 0) hands.step(of.path, valid(of.value + (steps * span) / 100));
    else return false;
    return true;
  }
  const hand = useHand(
    hands,
    of.path,
    (from) => (to) => valid(lo + (1 - (to.y + y - from.y - MARGIN) / height) * span),
    byKey,
  );
  if (!canEdit) return <StillMark {...{ of, legend, height }} />;
  return (
    <path
      className={isBeyond(of, legend) ? 'mark mark-beyond' : 'mark'}
      d={shapeOf(y)}
      role="slider"
      tabIndex={0}
      aria-label={`Move ${of.label}`}
      aria-orientation="vertical"
      aria-valuenow={of.value}
      aria-valuemin={lo}
      aria-valuemax={hi}
      {...hand}
    />
  );
}
