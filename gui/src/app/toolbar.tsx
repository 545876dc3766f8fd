// SPDX-License-Identifier: Apache-2.0
import { useRef } from 'react';
import { useForms } from '../out/forms';
import { useViews } from '../view/views';
import { openStateFile, savePicture, saveState } from './commands';
import { useServer } from './server';
import { useTheme } from './theme';

/** The page's buttons, above the views. */
export function Toolbar({ onHelp, onSearch }: { onHelp: () => void; onSearch: () => void }) {
  const server = useServer();
  const file = useRef<HTMLInputElement>(null);
  const view = useViews(({ views, active }) => views.find(({ id }) => id === active));
  const { theme, next } = useTheme();
  return (
    <div className="toolbar" role="toolbar" aria-label="Galaxy">
      <input
        ref={file}
        type="file"
        accept=".json,application/json"
        className="unseen"
        tabIndex={-1}
        aria-label="State file"
        onChange={({ currentTarget }) => {
          const chosen = currentTarget.files?.[0];
          if (chosen) void openStateFile(server, chosen);
          currentTarget.value = ''; // The same file can be chosen again.
        }}
      />
      <button type="button" onClick={() => file.current?.click()}>
        Open state file
      </button>
      <button
        type="button"
        disabled={!view}
        onClick={() => {
          if (view) saveState(view);
        }}
      >
        Save state file
      </button>
      <button
        type="button"
        disabled={!view}
        onClick={() => {
          if (view) void savePicture(view);
        }}
      >
        Save picture
      </button>
      <button
        type="button"
        disabled={!view}
        title="In any size, with or without what stands over it (P)"
        onClick={() => {
          if (view) useForms.getState().show('picture', view);
        }}
      >
        Export picture
      </button>
      <button
        type="button"
        disabled={!view}
        title="Have the server make many pictures of the view, from many sides (m)"
        onClick={() => {
          if (view) useForms.getState().show('cinema', view);
        }}
      >
        Cinema
      </button>
      <span className="space" />
      <button type="button" title="Commands, nodes, views and data (Ctrl+K)" onClick={onSearch}>
        Search
      </button>
      <button type="button" onClick={next}>
        Theme: {theme}
      </button>
      <button type="button" onClick={onHelp}>
        Help
      </button>
    </div>
  );
}
