// SPDX-License-Identifier: Apache-2.0
// The files of the server: the user walks through the data folders, and views a file or adds it to the graph.
import { type KeyboardEvent, useEffect, useRef, useState } from 'react';
import { Foreign } from '../app/foreign';
import { useConnectionState, useServer } from '../app/server';
import { messageOf } from '../graph/session';
import { bytesText } from '../graph/states';
import './file_browser.css';
import {
  type FileGroup,
  type Folder,
  grouped,
  inside,
  readFolder,
  type ServerFile,
  wayTo,
} from './server_files';

interface FileActions {
  readonly onView: (path: string) => void;
  /** Adds a file to the graph that is open; without: none is. */
  readonly onAdd: ((path: string) => void) | undefined;
}

/** Arrow keys go from row to row; the first button of a row has the focus. */
function walk(event: KeyboardEvent<HTMLElement>): void {
  const by = event.key === 'ArrowDown' ? 1 : event.key === 'ArrowUp' ? -1 : 0;
  const rows = [...event.currentTarget.querySelectorAll('tbody tr')];
  const at = rows.findIndex((row) => row.contains(document.activeElement));
  const next = rows[at + by]?.querySelector('button');
  if (by === 0 || !next) return;
  next.focus();
  event.preventDefault();
}

function FolderRow({ name, onOpen }: { readonly name: string; readonly onOpen: () => void }) {
  return (
    <tr>
      <th scope="row">
        <button type="button" className="plain" aria-label={`Open folder ${name}`} onClick={onOpen}>
          <Foreign text={`${name}/`} />
        </button>
      </th>
      <td />
      <td />
    </tr>
  );
}

interface FileRowProps extends FileActions {
  readonly name: string;
  readonly bytes: number;
  readonly path: string;
  /** Of the row of a series: how many files it has, and shows or hides them. */
  readonly series?: { readonly count: number; readonly isOpen: boolean; readonly onToggle: () => void };
}

function FileRow({ name, bytes, path, series, onView, onAdd }: FileRowProps) {
  return (
    <tr>
      <th scope="row">
        {series && (
          <button
            type="button"
            className="plain"
            aria-expanded={series.isOpen}
            aria-label={`Files of series ${name}`}
            onClick={series.onToggle}
          >
            {series.isOpen ? '▾' : '▸'}
          </button>
        )}
        <Foreign text={name} />
        {series && <span className="weak"> {series.count} steps</span>}
      </th>
      <td>
        <button type="button" aria-label={`View file ${name}`} onClick={() => onView(path)}>
          View
        </button>{' '}
        {onAdd && (
          <button type="button" aria-label={`Add file ${name} to the graph`} onClick={() => onAdd(path)}>
            Add
          </button>
        )}
      </td>
      <td className="number">{bytesText(bytes)}</td>
    </tr>
  );
}

/** The row of a series and, if they are asked for, those of its files. */
function GroupRows({
  group,
  folder,
  ...actions
}: FileActions & { readonly group: FileGroup; readonly folder: string }) {
  const [isOpen, setOpen] = useState(false);
  const bytes = group.files.reduce((sum, file) => sum + file.bytes, 0);
  const series = { count: group.files.length, isOpen, onToggle: () => setOpen(!isOpen) };
  const name = group.pattern.replace('%d', '*');
  return (
    <>
      <FileRow {...{ name, bytes, series, ...actions }} path={inside(folder, group.pattern)} />
      {isOpen &&
        group.files.map((file) => (
          <FileRow key={file.name} {...file} {...actions} path={inside(folder, file.name)} />
        ))}
    </>
  );
}

const isGroup = (entry: ServerFile | FileGroup): entry is FileGroup => 'pattern' in entry;

function Way({ path, onOpen }: { readonly path: string; readonly onOpen: (path: string) => void }) {
  return (
    <nav aria-label="Folder">
      <button type="button" className="plain" onClick={() => onOpen('')}>
        data folders
      </button>
      {wayTo(path).map(([name, own]) => (
        <span key={own}>
          /
          <button type="button" className="plain" onClick={() => onOpen(own)}>
            <Foreign text={name} />
          </button>
        </span>
      ))}
    </nav>
  );
}

function OpenBrowser(actions: FileActions) {
  const server = useServer();
  const isOpen = useConnectionState().kind === 'open';
  const [path, setPath] = useState('');
  const [folder, setFolder] = useState<Folder>();
  const [problem, setProblem] = useState('');
  const list = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!isOpen) return;
    let isWanted = true;
    readFolder(server, path).then(
      (read) => {
        if (!isWanted) return;
        setFolder(read);
        setProblem('');
      },
      (error: unknown) => {
        if (isWanted) setProblem(messageOf(error));
      },
    );
    return () => {
      isWanted = false;
    };
  }, [server, path, isOpen]);
  // The row that had the focus is gone, so the first of the new ones gets it, and the keyboard goes on from there.
  useEffect(() => list.current?.querySelector<HTMLElement>('tbody button')?.focus(), [folder]);

  // State files are in the server's list, too, but it gives nobody their text.
  const files = folder?.files.filter(({ name }) => !name.endsWith('.json')) ?? [];
  return (
    <>
      <Way path={path} onOpen={setPath} />
      {problem !== '' && (
        <p className="error" role="alert">
          <Foreign text={problem} />
        </p>
      )}
      <div ref={list} className="file-list" onKeyDown={walk} role="group" aria-label="Files of the server">
        <table className="data-list">
          <tbody>
            {folder?.folders.map((name) => (
              <FolderRow key={name} name={name} onOpen={() => setPath(inside(folder.path, name))} />
            ))}
            {grouped(files).map((entry) =>
              isGroup(entry) ? (
                <GroupRows key={entry.pattern} group={entry} folder={folder?.path ?? ''} {...actions} />
              ) : (
                <FileRow
                  key={entry.name}
                  {...entry}
                  {...actions}
                  path={inside(folder?.path ?? '', entry.name)}
                />
              ),
            )}
          </tbody>
        </table>
        {folder && folder.folders.length + files.length === 0 && (
          <p className="weak">No data are in this folder.</p>
        )}
        {folder?.isCut && <p className="weak">The folder has more than the server lists.</p>}
      </div>
    </>
  );
}

export function FileBrowser(actions: FileActions) {
  const [isShown, setShown] = useState(false);
  return (
    <section className="file-browser" aria-label="Files">
      <button type="button" aria-expanded={isShown} onClick={() => setShown(!isShown)}>
        Browse files
      </button>
      {isShown && <OpenBrowser {...actions} />}
    </section>
  );
}
