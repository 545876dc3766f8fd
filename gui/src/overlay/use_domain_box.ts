// SPDX-License-Identifier: Apache-2.0
// The box of a dataset of the graph that is open, of its newest generation.
import { useEffect, useState } from 'react';
import { useGraphStore, useNodeGraph, useSnapshot } from '../canvas/graph_store';
import { type Json, member, objectsIn } from '../graph/json';
import { idOf } from '../graph/nodes';
import { boxIn } from '../panels/additions';
import type { Box } from '../view/camera';
import { statement } from '../wire/statement';

/** Undefined until the server has told it, and if it has no such data. `name`: of the dataset's node. */
export function useDomainBox(name: string): Box | undefined {
  const connection = useGraphStore((s) => s.connection);
  const snapshot = useSnapshot();
  const id = idOf('Datasets', name);
  const node = useNodeGraph().byId.get(id);
  const dataset = node?.role === 'live' ? name : `${snapshot?.name}/${name}`;
  const generation = snapshot?.states.get(id)?.generation;
  const [told, setTold] = useState<{ dataset: string; box: Box | undefined }>();

  useEffect(() => {
    if (!connection || !node || generation === undefined) return;
    let isWanted = true;
    connection.request(statement('data.info', [dataset])).then(
      (reply) => {
        const info = objectsIn(member(reply as Json, 'datasets'))[0] ?? {};
        if (isWanted) setTold({ dataset, box: boxIn(info) });
      },
      () => undefined, // The seeds' node says what is wrong with its domain.
    );
    return () => {
      isWanted = false;
    };
    // Another object for the same node is no reason to ask again.
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [connection, dataset, generation, node === undefined]);

  return told?.dataset === dataset ? told.box : undefined;
}
