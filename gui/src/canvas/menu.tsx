// SPDX-License-Identifier: Apache-2.0
// A list to choose from, with a field that narrows it: the add menu, and the list of what an input or output can be connected with.
// The keys are those of a combobox: arrows, Enter, Escape.
import { type KeyboardEvent, useEffect, useId, useRef, useState } from 'react';
import { Foreign } from '../app/foreign';
import type { MenuItem } from './menu_item';

interface MenuProps<Item extends MenuItem> {
  readonly name: string;
  readonly at: { readonly x: number; readonly y: number }; // pixels of the place that it lies in
  readonly items: (typed: string) => readonly Item[];
  readonly onChoose: (item: Item) => void;
  /** `isLeft`: the focus goes to something else. */
  readonly onClose: (isLeft: boolean) => void;
}

export function Menu<Item extends MenuItem>({ name, at, items, onChoose, onClose }: MenuProps<Item>) {
  const [typed, setTyped] = useState('');
  const [chosen, setChosen] = useState(0);
  const box = useRef<HTMLDivElement>(null);
  const id = useId();
  const shown = items(typed);
  const current = Math.min(chosen, shown.length - 1);
  const item = shown[current];

  useEffect(() => {
    if (box.current) placeInside(box.current, at);
  }, [at]);
  useEffect(() => {
    box.current?.querySelector('[aria-selected=true]')?.scrollIntoView({ block: 'nearest' });
  }, [current, typed]);

  function key(event: KeyboardEvent): void {
    event.stopPropagation();
    const by = event.key === 'ArrowDown' ? 1 : event.key === 'ArrowUp' ? -1 : 0;
    if (by !== 0 && shown.length > 0) setChosen((current + by + shown.length) % shown.length);
    else if (event.key === 'Enter' && item) onChoose(item);
    else if (event.key === 'Escape' || event.key === 'Tab') onClose(false);
    else return;
    event.preventDefault();
  }

  return (
    <div
      ref={box}
      className="menu nopan nowheel"
      onBlur={(event) => {
        if (!event.currentTarget.contains(event.relatedTarget)) onClose(true);
      }}
    >
      <input
        ref={(element) => element?.focus({ preventScroll: true })}
        role="combobox"
        aria-label={name}
        aria-expanded
        aria-controls={id}
        aria-autocomplete="list"
        aria-activedescendant={shown.length > 0 ? `${id}-${current}` : undefined}
        placeholder={name}
        value={typed}
        onChange={(event) => {
          setTyped(event.target.value);
          setChosen(0);
        }}
        onKeyDown={key}
      />
      <ul id={id} role="listbox" aria-label={name} tabIndex={-1}>
        {shown.map((each, i) => (
          <li
            key={each.key}
            id={`${id}-${i}`}
            role="option"
            aria-selected={i === current}
            data-group={i === 0 || shown[i - 1]?.group !== each.group ? each.group : undefined}
            onPointerMove={() => setChosen(i)}
            onPointerDown={(event) => {
              event.preventDefault();
              onChoose(each);
            }}
          >
            <Foreign text={each.label} />
            <span className="weak">
              {' '}
              <Foreign text={each.help} />
            </span>
          </li>
        ))}
      </ul>
      {item && item.help !== '' && (
        <p className="menu-help weak">
          <Foreign text={item.help} />
        </p>
      )}
      {shown.length === 0 && <p className="weak">Nothing fits.</p>}
    </div>
  );
}

/** Puts the menu at a point, or so much beside it that the menu is inside of what it lies in. */
function placeInside(menu: HTMLElement, at: { x: number; y: number }): void {
  const place = menu.offsetParent;
  if (!place) return;
  menu.style.left = `${Math.max(4, Math.min(at.x, place.clientWidth - menu.offsetWidth - 4))}px`;
  menu.style.top = `${Math.max(4, Math.min(at.y, place.clientHeight - menu.offsetHeight - 4))}px`;
}
