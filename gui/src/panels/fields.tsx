// SPDX-License-Identifier: Apache-2.0
// Fields of the properties form, one for each kind of value.
import { type KeyboardEvent, type PointerEvent, useId, useRef, useState } from 'react';
import type { ValueType } from '../graph/value_type';
import { type Json, isList } from '../graph/json';
import { colorOf, defaultValue, hexOf, isOf, parsed, rounded, shown, stepOf } from './values';

export interface FieldProps {
  readonly id: string;
  readonly name: string; // for people, and for tests
  readonly type: ValueType;
  readonly value: Json | undefined;
  readonly defaultText: string;
  readonly describedBy: string;
  readonly isWrong: boolean;
  /** Undefined: the property is not said any more. `live`: more follow of the same `gesture`. */
  readonly onValue: (value: Json | undefined, gesture?: string, live?: boolean) => void;
  readonly onProblem: (text: string) => void;
}

let gestures = 0;

/** Text is taken when the field is left or Enter is pressed; Escape forgets it. */
function TextField(props: FieldProps & { readonly isLong: boolean }) {
  const { id, name, type, value, defaultText, describedBy, isWrong, isLong, onValue, onProblem } = props;
  const [draft, setDraft] = useState<string>();
  const text = draft ?? shown(value, type);

  function take(): void {
    if (draft === undefined) return;
    const { value: next, problem } = parsed(draft, type);
    if (problem !== undefined) {
      onProblem(problem);
      return; // What was typed stays, to be mended.
    }
    setDraft(undefined);
    onProblem('');
    if (draft !== shown(value, type)) onValue(next);
  }
  function step(by: number): void {
    if (type.kind !== 'number') return;
    const before = Number(text === '' ? (defaultValue(defaultText) ?? 0) : text);
    if (Number.isNaN(before)) return;
    const size = stepOf(before, type);
    setDraft(undefined);
    onProblem('');
    const next = parsed(String(rounded(before + by * size, size)), type);
    if (next.value !== undefined) onValue(next.value, `step ${id}`);
  }
  function key(event: KeyboardEvent): void {
    event.stopPropagation();
    if (event.key === 'Escape') {
      setDraft(undefined);
      onProblem('');
    } else if (event.key === 'Enter' && (!isLong || event.ctrlKey)) take();
    else if (type.kind === 'number' && (event.key === 'ArrowUp' || event.key === 'ArrowDown'))
      step(event.key === 'ArrowUp' ? 1 : -1);
    else return;
    event.preventDefault();
  }
  const common = {
    id,
    value: text,
    'data-property': name,
    'aria-describedby': describedBy,
    'aria-invalid': isWrong,
    spellCheck: false,
    placeholder: defaultText.replace(/`/g, ''),
    onBlur: take,
    onKeyDown: key,
    onChange: (event: { target: { value: string } }) => setDraft(event.target.value),
  };
  if (isLong) return <textarea {...common} rows={Math.min(6, Math.max(2, text.split('\n').length))} />;
  return (
    <input
      {...common}
      type="text"
      inputMode={type.kind === 'number' ? 'decimal' : 'text'}
      autoComplete="off"
    />
  );
}

/** A number, and a handle that changes it by dragging: one edit after the other, one step for undo. */
function NumberField(props: FieldProps) {
  const { type, value, defaultText, onValue } = props;
  const drag = useRef<{ x: number; value: number; gesture: string; last: number }>(undefined);
  if (type.kind !== 'number') return null;

  function begin(event: PointerEvent): void {
    const before = value ?? defaultValue(defaultText) ?? 0;
    if (typeof before !== 'number') return;
    event.currentTarget.setPointerCapture(event.pointerId);
    drag.current = { x: event.clientX, value: before, gesture: `drag ${++gestures}`, last: before };
  }
  function go(event: PointerEvent, live: boolean): void {
    const { current } = drag;
    if (!current || type.kind !== 'number') return;
    const step = stepOf(current.value, type);
    const { min = -Infinity, max = Infinity } = type.range;
    const wanted = rounded(current.value + Math.round((event.clientX - current.x) / 4) * step, step);
    const next = Math.min(max, Math.max(min, wanted));
    const isGood = parsed(String(next), type).problem === undefined;
    if (isGood && (next !== current.last || !live)) onValue(next, current.gesture, live);
    current.last = next;
  }
  return (
    <span className="number-field">
      <TextField {...props} isLong={false} />
      <span
        className="drag-number"
        title="Drag to change"
        aria-hidden
        onPointerDown={begin}
        onPointerMove={(event) => go(event, true)}
        onPointerUp={(event) => {
          if (drag.current && drag.current.last !== drag.current.value) go(event, false);
          drag.current = undefined;
        }}
      >
        ⇔
      </span>
    </span>
  );
}

function ColorField({ id, name, value, defaultText, describedBy, onValue }: FieldProps) {
  const color = value ?? defaultValue(defaultText);
  const gesture = useRef('');
  const isChanged = useRef(false); // since it has the focus
  const alpha = isList(color) ? color[3] : undefined;
  return (
    <span className="number-field">
      <input
        id={id}
        type="color"
        data-property={name}
        aria-describedby={describedBy}
        value={hexOf(color)}
        onFocus={() => {
          gesture.current = `color ${++gestures}`;
          isChanged.current = false;
        }}
        onChange={(event) => {
          isChanged.current = true;
          onValue(colorOf(event.target.value, color), gesture.current, true);
        }}
        onBlur={() => {
          if (isChanged.current && value !== undefined) onValue(value, gesture.current);
          isChanged.current = false;
        }}
      />
      {typeof alpha === 'number' && <span className="weak">alpha {alpha}</span>}
    </span>
  );
}

function ChoiceField({ id, name, type, value, defaultText, describedBy, isWrong, onValue }: FieldProps) {
  if (type.kind !== 'choice') return null;
  const preset = defaultValue(defaultText);
  const text = typeof value === 'string' ? value : '';
  const others = text !== '' && !type.choices.includes(text) ? [text] : [];
  return (
    <select
      id={id}
      data-property={name}
      aria-describedby={describedBy}
      aria-invalid={isWrong}
      value={text}
      onChange={(event) => onValue(event.target.value === '' ? undefined : event.target.value)}
    >
      <option value="">
        {typeof preset === 'string' ? `${preset} (default)` : defaultText.replace(/`/g, '') || 'choose'}
      </option>
      {[...type.choices, ...others].map((choice) => (
        <option key={choice} value={choice}>
          {choice}
        </option>
      ))}
    </select>
  );
}

function FlagField({ id, name, value, defaultText, describedBy, onValue }: FieldProps) {
  return (
    <input
      id={id}
      type="checkbox"
      data-property={name}
      aria-describedby={describedBy}
      checked={(value ?? defaultValue(defaultText)) === true}
      onChange={(event) => onValue(event.target.checked)}
    />
  );
}

/** A value of one of several types: which, and the value. */
function EitherField(props: FieldProps) {
  const { type, value, name, onValue } = props;
  const own = useId();
  const found = type.kind === 'either' ? type.types.findIndex((t) => isOf(value, t)) : 0;
  const [asked, setAsked] = useState<number>();
  if (type.kind !== 'either') return null;
  const place = asked ?? Math.max(0, found);
  const chosen = type.types[place] as ValueType;
  const called = (t: ValueType): string =>
    t.kind === 'word' ? t.word : t.kind === 'vector' ? t.names.join(', ') : t.kind;
  return (
    <span className="either">
      <select
        id={own}
        aria-label={`Kind of ${name}`}
        value={place}
        onChange={(event) => {
          const next = type.types[Number(event.target.value)];
          setAsked(Number(event.target.value));
          if (next?.kind === 'word') onValue(next.word);
        }}
      >
        {type.types.map((t, i) => (
          <option key={called(t)} value={i}>
            {called(t)}
          </option>
        ))}
      </select>
      {chosen.kind !== 'word' && (
        <Field
          {...props}
          key={place}
          type={chosen}
          value={isOf(value, chosen) ? value : undefined}
          onValue={(next, gesture, live) => {
            setAsked(undefined);
            onValue(next, gesture, live);
          }}
        />
      )}
    </span>
  );
}

/** The field of a value. */
export function Field(props: FieldProps) {
  const { type, name, value } = props;
  if (value !== undefined && !isOf(value, type) && type.kind !== 'either')
    return <TextField {...props} type={{ kind: 'json', words: '' }} isLong />;
  switch (type.kind) {
    case 'number':
      return <NumberField {...props} />;
    case 'flag':
      return <FlagField {...props} />;
    case 'choice':
      return <ChoiceField {...props} />;
    case 'color':
      return <ColorField {...props} />;
    case 'either':
      return <EitherField {...props} />;
    case 'text':
      return <TextField {...props} isLong={name === 'expression' || name === 'where'} />;
    case 'list':
      return <TextField {...props} isLong={type.of.kind !== 'number'} />;
    case 'json':
      return <TextField {...props} isLong />;
    default:
      return <TextField {...props} isLong={false} />;
  }
}
