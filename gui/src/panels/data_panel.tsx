// SPDX-License-Identifier: Apache-2.0
// The list of data, from which views are opened.
import { Foreign } from '../app/foreign';
import { editing, useViewOnly } from '../app/view_only';
import { useNotices } from '../app/notices';
import { DATASET, useDatasets } from './data_list';

interface DataPanelProps {
  onView: (name: string) => void;
  /** Adds a dataset to the graph that is open; without: none is. */
  onAdd: ((name: string) => void) | undefined;
}

export function DataPanel({ onView, onAdd }: DataPanelProps) {
  const isViewOnly = useViewOnly();
  const datasets = useDatasets(useNotices((notices) => notices.fail));
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
        {datasets.map(({ name, type, shared, generation }) => (
          <tr
            key={`${shared ? 'shared' : 'private'} ${name}`}
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
              )}
            </td>
            <td>{type}</td>
            <td className="number">{generation}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
