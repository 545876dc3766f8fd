// SPDX-License-Identifier: Apache-2.0
// The range of values over which the maps are stretched.
import { useId } from 'react';
import { useGraphStore } from '../canvas/graph_store';
import type { GraphNode } from '../graph/nodes';
import { valueType } from '../graph/value_type';
import { Field } from '../panels/fields';
import { type LookMaps, type RangeKind, setRange, spanIn } from './look_maps';
import { numberText } from './plot';
import { type Span, spanOf } from './points';
import type { PointsOfLook } from './use_points';

const RANGE = valueType('[min, max]');

const KINDS: readonly (readonly [RangeKind, string])[] = [
  ['data', 'of the data, wider with later steps'],
  ['numbers', 'these numbers'],
  ['own', 'none: points are where they are'],
];

interface RangeRowProps {
  readonly node: GraphNode;
  readonly maps: LookMaps;
  readonly now: Span | undefined;
  readonly seen: Span | undefined;
  readonly points: PointsOfLook;
}

export function RangeRow({ node, maps, now, seen, points }: RangeRowProps) {
  const id = useId();
  const session = useGraphStore((s) => s.session);
  const set = (to: Span | 'data' | undefined, gesture?: string, live = false): void => {
    points.say('');
    session?.edit(setRange(node, maps, to), { live, ...(gesture === undefined ? {} : { gesture }) });
  };
  const present = maps.range ?? (maps.color.points && spanOf(maps.color.points)) ?? now ?? [0, 1];
  const offer = (label: string, title: string, span: Span | undefined) => (
    <button
      type="button"
      title={span ? `${title}: ${numberText(span[0])} to ${numberText(span[1])}` : title}
      disabled={!span}
      onClick={() => span && set(span)}
    >
      {label}
    </button>
  );
  return (
    <div className="map-row" role="group" aria-label="Data range">
      <label htmlFor={id}>range</label>
      <select
        id={id}
        value={maps.rangeKind}
        onChange={(event) => {
          const { value } = event.target;
          set(value === 'data' ? 'data' : value === 'own' ? undefined : present);
        }}
      >
        {KINDS.map(([kind, text]) => (
          <option key={kind} value={kind}>
            {text}
          </option>
        ))}
      </select>
      {maps.rangeKind === 'numbers' && maps.range && (
        <span className="map-range">
          <label className="unseen" htmlFor={`${id}-numbers`}>
            Ends of the range
          </label>
          <Field
            id={`${id}-numbers`}
            name="map range"
            type={RANGE}
            value={maps.range}
            defaultText=""
            describedBy={`${id}-help`}
            isWrong={false}
            onValue={(to) => {
              const span = spanIn(to);
              if (span) set(span);
              else points.say('range: expected [min, max] with min <= max');
            }}
            onProblem={(text) => points.say(text === '' ? '' : `range: ${text}`)}
          />
        </span>
      )}
      {offer('Now', 'The range of the data now', now)}
      {offer('All steps seen', 'The range of all steps that this page has seen', seen)}
      <span id={`${id}-help`} className="unseen">
        The least and the largest value of the range.
      </span>
    </div>
  );
}
