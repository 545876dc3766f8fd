// SPDX-License-Identifier: Apache-2.0
// All views as tabs.
import { type KeyboardEvent, useRef } from 'react';
import { Foreign } from '../app/foreign';
import { openWindow } from '../app/view_address';
import type { View } from './view';
import { ViewPane } from './view_pane';
import { useViews } from './views';

export function ViewArea({ onKey }: { onKey: (key: string, view: View) => boolean }) {
  const { views, active, activate, close } = useViews();
  const tabs = useRef<HTMLDivElement>(null);

  function key(event: KeyboardEvent, index: number) {
    const by = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
    const view = views[(index + by + views.length) % views.length];
    if (event.key === 'Delete') close(active);
    if (by === 0 || !view) return;
    activate(view.id);
    tabs.current?.querySelectorAll<HTMLElement>('[role=tab]')[views.indexOf(view)]?.focus();
  }

  if (views.length === 0)
    return <p className="empty">No view is open. Open a state file, or press View beside data.</p>;
  const front = views.find(({ id }) => id === active);
  return (
    <>
      <div className="tabs">
        <div ref={tabs} className="tab-list" role="tablist" aria-label="Views">
          {views.map((view, index) => (
            <button
              key={view.id}
              type="button"
              role="tab"
              className={view.id === active ? 'tab tab-active' : 'tab'}
              aria-selected={view.id === active}
              tabIndex={view.id === active ? 0 : -1}
              onClick={() => {
                activate(view.id);
              }}
              onKeyDown={(event) => {
                key(event, index);
              }}
            >
              <Foreign text={view.title} />
            </button>
          ))}
        </div>
        {front?.ofGraph && (
          <button
            type="button"
            className="plain"
            aria-label={`Open ${front.title} in a window of its own`}
            title="Open it in a window of its own"
            onClick={() => {
              if (front.ofGraph && openWindow(front.ofGraph)) close(front.id);
              else front.onNotice('The browser does not let this page open a window.');
            }}
          >
            ↗
          </button>
        )}
        {front && (
          <button
            type="button"
            className="plain"
            aria-label={`Close ${front.title}`}
            onClick={() => {
              close(front.id);
            }}
          >
            ×
          </button>
        )}
      </div>
      {views.map((view) => (
        <ViewPane key={view.id} view={view} shown={view.id === active} onKey={onKey} />
      ))}
    </>
  );
}
