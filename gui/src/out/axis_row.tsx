// SPDX-License-Identifier: Apache-2.0
import { Foreign } from '../app/foreign';
import type { Axis } from './sweep';

interface AxisRowProps {
  readonly axis: Axis;
  readonly problem: string;
  readonly onChange: (axis: Axis) => void;
}

/** Something that can be varied: whether, from where to where, and in how many values. */
export function AxisRow({ axis, problem, onChange }: AxisRowProps) {
  const keys = axis.entry ? (['from', 'to', 'count'] as const) : (['count'] as const);
  return (
    <div className="out-axis" role="group" aria-label={axis.label}>
      <label>
        <input
          type="checkbox"
          checked={axis.isChosen}
          onChange={(event) => onChange({ ...axis, isChosen: event.target.checked })}
        />
        <Foreign text={axis.label} />
      </label>
      {keys.map((key) => (
        <label key={key} className={key}>
          {key}
          <input
            inputMode="decimal"
            autoComplete="off"
            disabled={!axis.isChosen}
            value={axis[key]}
            aria-invalid={problem !== ''}
            onChange={(event) => onChange({ ...axis, [key]: event.target.value })}
          />
        </label>
      ))}
      {problem !== '' && (
        <span className="error" role="alert">
          {problem}
        </span>
      )}
    </div>
  );
}
