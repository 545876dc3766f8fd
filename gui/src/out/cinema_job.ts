// SPDX-License-Identifier: Apache-2.0
// The Cinema database that is being made. It goes on while the form is closed.
import { create } from 'zustand';
import { useNotices } from '../app/notices';
import type { JsonObject } from '../graph/json';
import type { Connection } from '../wire/connection';
import { numberOf, type JsonObject as WireObject, textOf, textsOf } from '../wire/json';
import { statement } from '../wire/statement';

export interface CinemaRequest {
  readonly state: JsonObject;
  readonly sweep: JsonObject;
  readonly steps: number;
  readonly to: string;
}

interface CinemaJob {
  /** Undefined: none is being made. */
  readonly running: { readonly to: string; readonly done: number; readonly of: number } | undefined;
  /** How the last one ended, for people; empty: none has. */
  readonly ended: string;
  start(connection: Connection, request: CinemaRequest): Promise<void>;
  cancel(): void;
}

const wordsOf = (request: CinemaRequest): WireObject => ({ ...request }) as unknown as WireObject;

let stop: AbortController | undefined;

export const useCinemaJob = create<CinemaJob>((set, get) => ({
  running: undefined,
  ended: '',
  async start(connection, request) {
    if (get().running) return;
    const { say, fail } = useNotices.getState();
    const { to } = request;
    stop = new AbortController();
    const { signal } = stop;
    set({ running: { to, done: 0, of: 0 }, ended: '' });
    try {
      const reply = await connection.request(statement('viewer.cinema', [], wordsOf(request)), {
        signal,
        onProgress: (event) =>
          set({ running: { to, done: numberOf(event, 'done'), of: numberOf(event, 'of') } }),
      });
      for (const warning of textsOf(reply, 'warnings')) say(warning);
      const folder = textOf(reply, 'database', to);
      const ended = `Made ${numberOf(reply, 'pictures')} pictures; ${folder} in the server's data folder has ${numberOf(reply, 'rows')}. Its index.html shows them.`;
      set({ running: undefined, ended });
      say(ended);
    } catch (error) {
      const text = error instanceof Error ? error.message : String(error);
      const ended = signal.aborted ? `Cancelled; ${to} has the pictures that were done.` : `${to}: ${text}`;
      set({ running: undefined, ended });
      if (signal.aborted) say(ended);
      else fail(error);
    }
  },
  cancel() {
    stop?.abort();
  },
}));

/** How many pictures a request would make of each step. Rejects with the server's reason if it would not make it. */
export async function countOf(connection: Connection, request: CinemaRequest): Promise<number> {
  const words = { ...wordsOf(request), estimate: true };
  return numberOf(await connection.request(statement('viewer.cinema', [], words)), 'pictures');
}
