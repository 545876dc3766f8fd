// SPDX-License-Identifier: Apache-2.0
import { useSyncExternalStore } from 'react';
import { useSnapshot } from '../canvas/graph_store';
import type { View } from '../view/view';
import type { StepShown } from './publishers';
import { useSteps } from './steps_store';

/** The step of a generation of a dataset; undefined: no simulation publishes it. */
export function useStepOf(dataset: string, generation: number | undefined): number | undefined {
  const shown = useSteps((s) => s.shown);
  return generation === undefined ? undefined : shown({ [dataset]: generation })[0]?.step;
}

/** The steps that a view shows, one for each publisher. */
export function useStepsShown(view: View): readonly StepShown[] {
  const status = useSyncExternalStore(
    (changed) => view.subscribe(changed),
    () => view.status,
  );
  const { shown, isPublished } = useSteps();
  const snapshot = useSnapshot();
  const isDirect = Object.keys(status.generations).some(isPublished);
  if (isDirect || view.ofGraph?.graph !== snapshot?.name) return shown(status.generations);
  // What filters have made says no step of its own: it is of the data that their graph has taken.
  const taken = Object.fromEntries(
    [...(snapshot?.states ?? [])].flatMap(([id, { generation }]): [string, number][] =>
      id.startsWith('Datasets/') && generation !== undefined
        ? [[id.slice('Datasets/'.length), generation]]
        : [],
    ),
  );
  return shown(taken);
}
