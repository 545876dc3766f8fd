// SPDX-License-Identifier: Apache-2.0
// Asks the server for its statistics while somebody looks at them.
import type { Connection, Unsubscribe } from '../wire/connection';
import type { JsonObject } from '../wire/json';

export const EVERY = 2000; // milliseconds

export interface PollHandlers {
  onReply(reply: JsonObject): void;
  /** The server does not tell them; it is asked again. */
  onProblem(error: unknown): void;
  /** From now on nothing is known: there is no connection, or nobody looks. */
  onPause(): void;
}

export class StatisticsPoll {
  private isWanted = false;
  private isAsking = false;
  private turn = 0; // What was asked in an earlier turn does not count.
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly end: Unsubscribe;

  constructor(
    private readonly connection: Connection,
    private readonly handlers: PollHandlers,
  ) {
    this.end = connection.onState(() => {
      this.pause(); // Another state is another socket, or none.
      this.look();
    });
  }

  setWanted(isWanted: boolean): void {
    this.isWanted = isWanted;
    this.look();
  }

  close(): void {
    this.setWanted(false);
    this.end();
  }

  private look(): void {
    const isPossible = this.isWanted && this.connection.state.kind === 'open';
    if (!isPossible) {
      this.pause();
    } else if (!this.isAsking) {
      this.isAsking = true;
      void this.ask(++this.turn);
    }
  }

  private pause(): void {
    if (!this.isAsking) return;
    this.isAsking = false;
    this.turn++;
    clearTimeout(this.timer);
    this.handlers.onPause();
  }

  private async ask(turn: number): Promise<void> {
    const due = new Promise((resolve) => {
      this.timer = setTimeout(resolve, EVERY);
    });
    try {
      const reply = await this.connection.request('stat');
      if (turn === this.turn) this.handlers.onReply(reply);
    } catch (error) {
      if (turn === this.turn) this.handlers.onProblem(error);
    }
    if (turn !== this.turn) return;
    await due;
    if (turn === this.turn) void this.ask(turn);
  }
}
