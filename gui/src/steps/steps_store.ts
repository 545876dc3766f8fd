// SPDX-License-Identifier: Apache-2.0
// The publishers of the server, for components.
import { create } from 'zustand';
import type { Connection } from '../wire/connection';
import { type JsonObject, textOf } from '../wire/json';
import { type Publisher, Publishers, type StepShown } from './publishers';

interface StepsStore {
  readonly publishers: readonly Publisher[];
  readonly shown: (generations: Readonly<Record<string, number>>) => readonly StepShown[];
  readonly isPublished: (name: string) => boolean;
}

export const useSteps = create<StepsStore>(() => ({
  publishers: [],
  shown: () => [],
  isPublished: () => false,
}));

/** Follows the publishers of a connection. Returns what ends that. The events are those that the list of data asks for (`data.observe`). */
export function watchSteps(connection: Connection): () => void {
  let known = new Publishers();
  let isAsking = false;
  let isDue = false;
  const tell = (): void => {
    const now = known;
    useSteps.setState({
      publishers: now.list,
      shown: (generations) => now.shown(generations),
      isPublished: (name) => now.isPublished(name),
    });
  };
  // Asked for after each step, but for those that come while a question is not answered: these are asked for once.
  async function ask(): Promise<void> {
    isDue = isAsking;
    if (isAsking || connection.state.kind !== 'open') return;
    isAsking = true;
    try {
      known.streams(await connection.request('insitu.streams'));
      tell();
    } catch {
      // A server without this module has no simulations. That a connection is lost is said elsewhere.
    }
    isAsking = false;
    if (isDue) await ask();
  }
  function begin(): void {
    if (connection.state.kind !== 'open') return;
    known = new Publishers();
    const now = known;
    connection.request('insitu.listen').catch(() => undefined);
    connection.request('data.info').then(
      (reply) => {
        now.info(reply);
        void ask();
      },
      () => undefined,
    );
  }
  const take = (event: JsonObject): void => {
    if (!known.event(event, Date.now())) return;
    tell();
    void ask();
  };
  begin();
  const ends = [
    connection.onState(begin),
    connection.on('added', take),
    connection.on('updated', take),
    connection.on('dropped', (event) => known.dropped(textOf(event, 'name'))),
    connection.on('skipped', () => void ask()),
    connection.on('stream ended', () => void ask()),
  ];
  return () => {
    for (const end of ends) end();
  };
}
