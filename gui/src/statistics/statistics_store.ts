// SPDX-License-Identifier: Apache-2.0
// The statistics of the server, for components. They stay when the tab is closed, so that it shows them when it is opened again.
import { create } from 'zustand';
import { useGraphStore } from '../canvas/graph_store';
import { messageOf } from '../graph/session';
import type { Connection } from '../wire/connection';
import { EvaluationTimes } from './evaluation';
import { type Row, withRow } from './history';
import { StatisticsPoll } from './poll';
import { type Kind, KINDS, type Sample, sampleOf } from './sample';
import { type Looks, looksFor, shownNames } from './series';

interface StatisticsStore {
  readonly rows: readonly Row[];
  /** The looks of the lines of each kind. */
  readonly looks: ReadonlyMap<Kind, Looks>;
  /** Why the server does not tell them; empty: it does. */
  readonly problem: string;
}

export const useStatistics = create<StatisticsStore>(() => ({ rows: [], looks: new Map(), problem: '' }));

const now = (): number => (performance.timeOrigin + performance.now()) / 1000;

function add(sample: Sample | undefined, problem = ''): void {
  useStatistics.setState((before) => {
    const rows = withRow(before.rows, now(), sample);
    const looks = new Map(
      KINDS.map((kind) => [kind, looksFor(shownNames(rows, kind), before.looks.get(kind) ?? new Map())]),
    );
    return { rows, looks, problem };
  });
}

/** Follows the statistics while the page is visible. Returns what ends that. */
export function followStatistics(connection: Connection): () => void {
  const evaluation = new EvaluationTimes();
  const poll = new StatisticsPoll(connection, {
    onReply: (reply) => {
      const snapshot = useGraphStore.getState().session?.snapshot;
      const { state } = connection;
      const session = state.kind === 'open' ? state.welcome.session : 0;
      add(sampleOf(reply, session, evaluation.of(snapshot?.name, snapshot?.states)));
    },
    onProblem: (error) => add(undefined, messageOf(error)),
    onPause: () => add(undefined),
  });
  const look = (): void => poll.setWanted(document.visibilityState === 'visible');
  document.addEventListener('visibilitychange', look);
  look();
  return () => {
    document.removeEventListener('visibilitychange', look);
    poll.close();
  };
}
