// SPDX-License-Identifier: Apache-2.0
// The exact numbers of the point that is selected.
import { useId, useState } from 'react';
import { Foreign } from '../app/foreign';
import { type Json, isList } from '../graph/json';
import { valueType } from '../graph/value_type';
import { Field } from '../panels/fields';
import type { LookMap, LookMaps } from './look_maps';
import type { Point } from './points';
import type { PointsOfLook } from './use_points';

const VALUE = valueType('number');
const OPACITY = valueType('number 0 to 1');
const EXTINCTION = valueType('number >= 0');
const COLOR = valueType('[r, g, b] of 0 to 1');
const CHANNELS = valueType('[r, g, b]');

interface OneFieldProps {
  readonly label: string;
  readonly name: string;
  readonly type: typeof VALUE;
  readonly value: Json;
  readonly isFixed?: boolean;
  readonly onValue: (value: Json, gesture?: string, live?: boolean) => void;
}

function OneField({ label, name, type, value, isFixed = false, onValue }: OneFieldProps) {
  const id = useId();
  const [problem, setProblem] = useState('');
  return (
    <div className={`map-field${problem === '' ? '' : ' wrong'}`}>
      <label htmlFor={id}>{label}</label>
      {isFixed ? (
        <input id={id} value={String(value)} readOnly aria-describedby={`${id}-help`} data-property={name} />
      ) : (
        <Field
          {...{ id, name, type, value, defaultText: '', isWrong: problem !== '' }}
          describedBy={`${id}-help`}
          onValue={(next, gesture, live) => next !== undefined && onValue(next, gesture, live)}
          onProblem={setProblem}
        />
      )}
      <span
        id={`${id}-help`}
        className={problem === '' ? 'weak' : 'error'}
        role={problem === '' ? undefined : 'alert'}
      >
        {problem === '' ? isFixed && 'end of the range' : <Foreign text={problem} />}
      </span>
    </div>
  );
}

interface PointFieldsProps {
  readonly maps: LookMaps;
  readonly points: PointsOfLook;
  readonly onAdd: () => void;
}

export function PointFields({ maps, points, onAdd }: PointFieldsProps) {
  const { selected } = points;
  const map: LookMap | undefined = selected?.kind === 'opacity' ? maps.opacity : maps.color;
  const all = map?.points ?? [];
  const point = selected && (map?.kind === 'opacity' || map?.name === '') ? all[selected.place] : undefined;
  if (!selected || !map || !point)
    return (
      <p className="map-row weak">
        A double click on the curve or the colours adds a point. A point that is selected has its numbers
        here.
      </p>
    );
  const { place } = selected;
  const [value, ...what] = point;
  const isEnd = maps.range !== undefined && (place === 0 || place === all.length - 1);
  const set = (to: Point, gesture?: string, live?: boolean): void =>
    points.set(map, place, to, gesture, live);
  const channels = (to: Json): readonly number[] =>
    isList(to) ? (to as readonly number[]).slice(0, 3) : what;
  return (
    <div className="map-row" role="group" aria-label="Selected point" key={`${map.key} ${place}`}>
      <span className="weak">
        {map.kind === 'opacity' ? 'Point' : 'Colour'} {place + 1} of {all.length}
      </span>
      <OneField
        label="value"
        name="map value"
        type={VALUE}
        value={value}
        isFixed={isEnd}
        onValue={(to, ...more) => set([to as number, ...what], ...more)}
      />
      {map.kind === 'opacity' ? (
        <OneField
          label={maps.isExtinction ? 'extinction' : 'opacity'}
          name="map opacity"
          type={maps.isExtinction ? EXTINCTION : OPACITY}
          value={what[0] as number}
          onValue={(to, ...more) => set([value, to as number], ...more)}
        />
      ) : (
        <>
          <OneField
            label="colour"
            name="map colour"
            type={COLOR}
            value={what}
            onValue={(to, ...more) => set([value, ...channels(to)], ...more)}
          />
          <OneField
            label="red, green, blue"
            name="map channels"
            type={CHANNELS}
            value={what}
            onValue={(to, ...more) => set([value, ...channels(to)], ...more)}
          />
        </>
      )}
      <button type="button" onClick={onAdd} title="Between this point and the next">
        Add point
      </button>
      <button type="button" onClick={() => points.remove(map, place)} title="Delete">
        Remove point
      </button>
    </div>
  );
}
