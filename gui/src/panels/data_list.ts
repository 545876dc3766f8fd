// SPDX-License-Identifier: Apache-2.0
// The datasets that the tenant sees, kept current by the server's events.
import { useEffect, useState } from 'react';
import { useServer } from '../app/server';
import type { Connection } from '../wire/connection';
import { numberOf, objectsOf, textOf } from '../wire/json';

/** What a dataset is called while it is dragged. */
export const DATASET = 'application/x-galaxy-dataset';

export interface Dataset {
  name: string;
  type: string;
  shared: boolean;
  readOnly: boolean;
  generation: number;
}

const CHANGES = ['added', 'updated', 'dropped', 'renamed', 'lost'];

/** Calls `tell` with the list at each connection and after each change of it. Returns what ends that. */
export function watchDatasets(
  connection: Connection,
  tell: (datasets: Dataset[]) => void,
  fail: (error: unknown) => void,
): () => void {
  let asking = false;
  let again = false;
  async function ask(): Promise<void> {
    if (asking || connection.state.kind !== 'open') {
      again = asking;
      return;
    }
    asking = true;
    try {
      tell(objectsOf(await connection.request('data.list'), 'datasets').map(datasetOf));
    } catch (error) {
      if (connection.state.kind === 'open') fail(error); // Else the page says that the connection is lost.
    }
    asking = false;
    if (again) {
      again = false;
      await ask();
    }
  }
  function begin(): void {
    if (connection.state.kind !== 'open') return;
    connection.request('data.observe').catch(fail);
    void ask();
  }
  begin();
  const ends = [
    connection.onState(begin),
    ...CHANGES.map((event) =>
      connection.on(event, () => {
        void ask();
      }),
    ),
  ];
  return () => {
    for (const end of ends) end();
  };
}

function datasetOf(entry: Parameters<typeof textOf>[0]): Dataset {
  return {
    name: textOf(entry, 'name'),
    type: textOf(entry, 'type'),
    shared: textOf(entry, 'scope') === 'shared',
    readOnly: entry['read only'] === true,
    generation: numberOf(entry, 'generation'),
  };
}

export function useDatasets(fail: (error: unknown) => void): Dataset[] {
  const server = useServer();
  const [datasets, setDatasets] = useState<Dataset[]>([]);
  useEffect(() => watchDatasets(server, setDatasets, fail), [server, fail]);
  return datasets;
}
