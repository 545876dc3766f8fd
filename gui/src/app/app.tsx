// SPDX-License-Identifier: Apache-2.0
// The page: which part is at which place.
import { useCallback, useEffect, useState } from 'react';
import { showDataset, showFile } from '../canvas/actions';
import { GraphArea } from '../canvas/graph_area';
import { useGraphStore } from '../canvas/graph_store';
import { OutForms } from '../out/out_forms';
import { DataPanel } from '../panels/data_panel';
import { FileBrowser } from '../panels/file_browser';
import { PanelArea } from '../panels/panel_area';
import { watchSteps } from '../steps/steps_store';
import type { View } from '../view/view';
import { ViewArea } from '../view/view_area';
import { pressInView, viewData, viewFile } from './commands';
import { ConnectPage, ConnectionStatus, LossBar } from './connection_state';
import { Help } from './help';
import { Layout } from './layout';
import { NoticeList } from './notice_list';
import { Search } from './search';
import { useConnectionState, useServer } from './server';
import { Toolbar } from './toolbar';
import { viewIn } from './view_address';
import { ViewWindow } from './view_window';

export function App() {
  const state = useConnectionState();
  const server = useServer();
  const isGraphOpen = useGraphStore(({ session }) => session !== undefined);
  const [help, setHelp] = useState(false);
  const [search, setSearch] = useState(false);
  const showHelp = useCallback(() => setHelp(true), []);
  const [own] = useState(() => viewIn(location.hash)); // The view that this window is for.
  useEffect(() => watchSteps(server), [server]);
  useEffect(() => {
    const look = (event: KeyboardEvent): void => {
      if (event.key.toLowerCase() !== 'k' || !(event.ctrlKey || event.metaKey) || event.altKey) return;
      event.preventDefault();
      if (!document.querySelector('dialog[open]')) setSearch(true);
    };
    document.addEventListener('keydown', look);
    return () => document.removeEventListener('keydown', look);
  }, []);
  if (state.kind === 'locked' && !state.before) return <ConnectPage problem={state.problem} />;

  function onKey(key: string, view: View): boolean {
    if (key !== '?' && key !== 'h') return pressInView(key, view);
    setHelp(true);
    return true;
  }

  if (own)
    return (
      <>
        <div className="layout">
          <header>
            <LossBar />
          </header>
          <main className="place" aria-label="View">
            <ViewWindow address={own} onKey={onKey} />
          </main>
          <footer className="status" aria-label="Status">
            <ConnectionStatus />
          </footer>
        </div>
        <NoticeList />
        <OutForms />
        {help && <Help onClose={() => setHelp(false)} />}
      </>
    );
  return (
    <>
      <Layout
        top={
          <>
            <LossBar />
            <Toolbar onHelp={showHelp} onSearch={() => setSearch(true)} />
          </>
        }
        graph={<GraphArea connection={server} />}
        properties={
          <PanelArea
            liveData={
              <>
                <FileBrowser
                  onView={(path) => void viewFile(server, path)}
                  onAdd={isGraphOpen ? (path) => void showFile(path) : undefined}
                />
                <DataPanel
                  onView={(name) => {
                    void viewData(server, name);
                  }}
                  onAdd={isGraphOpen ? (name) => void showDataset(name) : undefined}
                />
              </>
            }
          />
        }
        views={<ViewArea onKey={onKey} />}
        status={<ConnectionStatus />}
      />
      <NoticeList />
      <OutForms />
      {search && <Search onHelp={showHelp} onClose={() => setSearch(false)} />}
      {help && (
        <Help
          onClose={() => {
            setHelp(false);
          }}
        />
      )}
    </>
  );
}
