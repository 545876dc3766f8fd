// SPDX-License-Identifier: Apache-2.0
// What lies below the graph: live data, the form of the selected node, its data, and the log.
import { type KeyboardEvent, type ReactNode, useLayoutEffect, useRef, useState } from 'react';
import { useGraphStore } from '../canvas/graph_store';
import { onUndoKey } from '../canvas/keys';
import { MapsTab } from '../maps/editor';
import { StatisticsTab } from '../statistics/statistics_tab';
import { StepsPanel } from '../steps/steps_panel';
import { DataTab } from './data_tab';
import { LogPanel } from './log_panel';
import './panels.css';
import { NodeForm, useSelectedNode } from './properties';

const TABS = ['Live data', 'Properties', 'Maps', 'Data', 'Log', 'Steps', 'Statistics'] as const;
type Tab = (typeof TABS)[number];

/** The tab in front once another node is selected. `isChosenSince`: the user has chosen the tab since the selection before. */
export function tabAfterSelection(tab: Tab, isChosenSince: boolean): Tab {
  if (tab === 'Live data') return 'Properties';
  return (tab === 'Steps' || tab === 'Log') && !isChosenSince ? 'Properties' : tab;
}

export function PanelArea({ liveData }: { readonly liveData: ReactNode }) {
  const [tab, setTab] = useState<Tab>('Live data');
  const node = useSelectedNode();
  const count = useGraphStore((s) => s.selection.length);
  const id = node?.id;
  const [followed, setFollowed] = useState<string>();
  const [hasSelected, setHasSelected] = useState(false); // a node, at any time
  const [isChosenSince, setChosenSince] = useState(false);
  const panel = useRef<HTMLDivElement>(null);
  // What another node or tab has begins at its top.
  useLayoutEffect(() => {
    if (panel.current) panel.current.scrollTop = 0;
  }, [tab, id]);
  if (id !== followed) {
    setFollowed(id);
    if (id !== undefined) {
      setTab(tabAfterSelection(tab, isChosenSince));
      setHasSelected(true);
      setChosenSince(false);
    }
  }
  function choose(name: Tab): void {
    setTab(name);
    setChosenSince(hasSelected);
  }

  function key(event: KeyboardEvent): void {
    const by = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
    const next = TABS[(TABS.indexOf(tab) + by + TABS.length) % TABS.length];
    if (by === 0 || !next) return;
    choose(next);
    document.getElementById(`tab ${next}`)?.focus();
  }
  const none = <p className="empty">{count > 1 ? `${count} nodes are selected.` : 'No node is selected.'}</p>;
  return (
    <div className="panel-area">
      <div className="tabs" role="tablist" aria-label="Panels">
        {TABS.map((name) => (
          <div key={name} className={name === tab ? 'tab tab-active' : 'tab'} role="presentation">
            <button
              type="button"
              role="tab"
              className="plain"
              id={`tab ${name}`}
              aria-selected={name === tab}
              aria-controls="panel"
              tabIndex={name === tab ? 0 : -1}
              onClick={() => choose(name)}
              onKeyDown={key}
            >
              {name}
            </button>
          </div>
        ))}
      </div>
      <div
        ref={panel}
        id="panel"
        role="tabpanel"
        aria-label={tab}
        className="panel"
        tabIndex={0}
        onKeyDown={onUndoKey}
      >
        {tab === 'Live data' && liveData}
        {tab === 'Properties' && (node ? <NodeForm node={node} /> : none)}
        {tab === 'Maps' && (node ? <MapsTab node={node} /> : none)}
        {tab === 'Data' && (node ? <DataTab node={node} /> : none)}
        {tab === 'Log' && <LogPanel />}
        {tab === 'Steps' && <StepsPanel />}
        {tab === 'Statistics' && <StatisticsTab />}
      </div>
    </div>
  );
}
