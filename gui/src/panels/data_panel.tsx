// SPDX-License-Identifier: Apache-2.0
// The list of data, from which views are opened and copies are made.
import { useRef, useState } from 'react';
import { Foreign } from '../app/foreign';
import { useNotices } from '../app/notices';
import { useServer } from '../app/server';
import { editing, useViewOnly } from '../app/view_only';
import { statement } from '../wire/statement';
import { copyName, keptText } from './copies';
import { DATASET, type Dataset, useDatasets } from './data_list';

interface DataPanelProps {
  onView: (name: string) => void;
  /** Adds a dataset to the graph that is open; without: none is. */
  onAdd: ((name: string) => void) | undefined;
}

interface RowProps extends DataPanelProps {
  dataset: Dataset;
  /** The names that mean something. */
  taken: ReadonlySet<string>;
  /** The name means a dataset of the tenant's own, and not this one. */
  isHidden: boolean;
}

function Row({ dataset: { name, type, shared, generation }, taken, isHidden, onView, onAdd }: RowProps) {
  const isViewOnly = useViewOnly();
  const server = useServer();
  const { say, fail } = useNotices.getState();
  const [isAsked, setAsked] = useState(false);
  // Names of copies that the list may not have yet.
  const given = useRef(new Set<string>());
  const keep = (): void => {
    const copy = copyName(name, new Set([...taken, ...given.current]));
    given.current.add(copy);
    server
      .request(statement('data.copy', [name, copy]))
      .then((reply) => say(keptText(name, copy, reply)), fail);
  };
  const onlyOwn = (help: string) =>
    editing(isViewOnly, isHidden ? 'A dataset of your own has this name' : help, isHidden);
  return (
    <tr
      draggable={onAdd !== undefined && !isViewOnly}
      onDragStart={(event) => {
        event.dataTransfer.setData(DATASET, name);
      }}
    >
      <th scope="row">
        <Foreign text={name} />
        {shared && <span className="weak"> (shared)</span>}
      </th>
      <td>
        <button
          type="button"
          aria-label={`View ${name}`}
          onClick={() => {
            onView(name);
          }}
        >
          View
        </button>{' '}
        {onAdd && (
          <button
            type="button"
            aria-label={`Add ${name} to the graph`}
            {...editing(
              isViewOnly,
              'Add it to the graph, with a look and to the view; or drag it onto the canvas',
            )}
            onClick={() => {
              onAdd(name);
            }}
          >
            Add
          </button>
        )}{' '}
        <button
          type="button"
          aria-label={`Keep a copy of ${name}`}
          {...onlyOwn('Keep what it is now under another name, which newer data do not change')}
          onClick={keep}
        >
          Keep
        </button>{' '}
        <button
          type="button"
          aria-label={isAsked ? `Really drop ${name}` : `Drop ${name}`}
          {...onlyOwn('Forget it on the server; files stay. It asks once more')}
          onBlur={() => {
            setAsked(false);
          }}
          onClick={() => {
            if (isAsked) server.request(statement('data.drop', [name])).catch(fail);
            setAsked(!isAsked);
          }}
        >
          {isAsked ? 'Really?' : 'Drop'}
        </button>
      </td>
      <td>{type}</td>
      <td className="number">{generation}</td>
    </tr>
  );
}

export function DataPanel({ onView, onAdd }: DataPanelProps) {
  const datasets = useDatasets(useNotices((notices) => notices.fail));
  const taken = new Set(datasets.map(({ name }) => name));
  const own = new Set(datasets.filter(({ shared }) => !shared).map(({ name }) => name));
  if (datasets.length === 0)
    return (
      <p className="empty">
        The server has no data yet. They come from files, or from a simulation that publishes.
      </p>
    );
  return (
    <table className="data-list">
      <thead>
        <tr>
          <th scope="col">Data</th>
          <th scope="col">
            <span className="unseen">View</span>
          </th>
          <th scope="col">Type</th>
          <th scope="col" className="number">
            Generation
          </th>
        </tr>
      </thead>
      <tbody>
        {datasets.map((dataset) => (
          <Row
            key={`${dataset.shared ? 'shared' : 'private'} ${dataset.name}`}
            isHidden={dataset.shared && own.has(dataset.name)}
            {...{ dataset, taken, onView, onAdd }}
          />
        ))}
      </tbody>
    </table>
  );
}
