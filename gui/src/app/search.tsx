// SPDX-License-Identifier: Apache-2.0
// The search: Ctrl+K finds commands, nodes, views and data by words of their names.
import { useState } from 'react';
import { focusCard, showDataset } from '../canvas/actions';
import { freshGraph } from '../canvas/graph_bar';
import { useGraphStore, useNodeGraph, useSnapshot } from '../canvas/graph_store';
import { Menu } from '../canvas/menu';
import { savePython } from '../out/as_python';
import { useForms } from '../out/forms';
import { useViews } from '../view/views';
import { saveGraph, savePicture, saveState, viewData } from './commands';
import './search.css';
import { foundItems, searchItems } from './search_items';
import { useServer } from './server';
import { useTheme } from './theme';
import { useViewOnly } from './view_only';

interface Command {
  readonly label: string;
  readonly keys: string;
  readonly run: () => void;
}

/** What can be done now, other than the keys of a view. */
function useCommands(onHelp: () => void): readonly Command[] {
  const { session } = useGraphStore();
  const snapshot = useSnapshot();
  const view = useViews(({ views, active }) => views.find(({ id }) => id === active));
  const isViewOnly = useViewOnly();
  const { next } = useTheme();
  const command = (label: string, keys: string, run: () => void): Command => ({ label, keys, run });
  const ofView = view
    ? [
        command('Save state file', 'w', () => saveState(view)),
        command('Save picture', 'p', () => void savePicture(view)),
        command('Export picture', 'P', () => useForms.getState().show('picture', view)),
        command('Cinema database', 'm', () => useForms.getState().show('cinema', view)),
      ]
    : [];
  const ofGraph = session
    ? [
        command('Save the graph as a state file', '', () => void saveGraph(session.name)),
        command('Save the graph as Python', 'P in the graph', savePython),
      ]
    : [];
  const edits =
    session && snapshot?.isViewOnly === false
      ? [
          command('Undo', 'Ctrl+Z', () => session.undo()),
          command('Redo', 'Ctrl+Y', () => session.redo()),
          command('Run the graph', '', () => session.run()),
          command(snapshot.isPaused ? 'Go on with the graph' : 'Pause the graph', '', () =>
            session.setPaused(!snapshot.isPaused),
          ),
        ]
      : [];
  return [
    ...ofView,
    ...ofGraph,
    ...edits,
    ...(isViewOnly ? [] : [command('New graph', '', freshGraph)]),
    command('Next theme', '', next),
    command('Help: mouse and keys', '?', onHelp),
  ];
}

/** The search, in the middle of the page. The focus goes back to where it was, or to the node that is chosen. */
export function Search({ onHelp, onClose }: { readonly onHelp: () => void; readonly onClose: () => void }) {
  const server = useServer();
  const [before] = useState(() => document.activeElement);
  const { views, active, activate } = useViews();
  const { nodes } = useNodeGraph();
  const { live, session, select, seek } = useGraphStore();
  const commands = useCommands(onHelp);
  const items = searchItems({
    ...{ view: views.find(({ id }) => id === active), views, nodes, datasets: live, commands },
    showView: (view) => activate(view.id),
    showNode: (id) => {
      select([id]);
      seek(id);
      focusCard(id);
    },
    viewData: (name) => void viewData(server, name),
    addData: session && (session.snapshot.isViewOnly ? undefined : (name) => void showDataset(name)),
  });
  function close(isLeft: boolean): void {
    onClose();
    if (!isLeft && before instanceof HTMLElement) before.focus({ preventScroll: true });
  }
  return (
    <div className="search">
      <Menu
        name="Search commands, nodes, views and data"
        at={{ x: 0, y: 0 }}
        items={(typed) => foundItems(items, typed)}
        onClose={close}
        onChoose={(item) => {
          close(false);
          item.run();
        }}
      />
    </div>
  );
}
