// SPDX-License-Identifier: Apache-2.0
// The graph session of a page, by which tests edit as the page's own parts do, and see what it has sent.
import type { JSHandle, Page } from 'playwright-core';
import type { Edit } from '../src/graph/edits';
import type { JsonObject } from '../src/graph/json';
import type { GraphSession } from '../src/graph/session';

/** What React keeps at an element: the values of a component's hooks, and the component around it. */
interface Hook {
  readonly memoizedState: unknown;
  readonly next: Hook | null;
}
interface Fiber {
  readonly memoizedState: Hook | null;
  readonly alternate: Fiber | null;
  readonly return: Fiber | null;
}

/** All that a page's session has done since it was looked at. */
export interface Account {
  readonly made: readonly (readonly Edit[])[]; // in the order in which they are sent
  readonly refused: number;
  readonly sessions: readonly number[]; // as the server counts them: one for each connection
}

export class PageSession {
  private constructor(
    private readonly page: Page,
    private readonly session: JSHandle<GraphSession & { account: Account }>,
  ) {}

  /** The session of the graph that is open on the page. */
  static async of(page: Page): Promise<PageSession> {
    const handle = await page.evaluateHandle(() => {
      const element = document.querySelector('.graph-bar') ?? document.body;
      const key = Object.keys(element).find((k) => k.startsWith('__reactFiber$')) ?? '';
      let fiber = (element as unknown as Record<string, Fiber | null>)[key] ?? null;
      for (; fiber; fiber = fiber.return)
        for (const state of [fiber.memoizedState, fiber.alternate?.memoizedState])
          for (let hook = state; hook; hook = hook.next) {
            const value = hook.memoizedState as GraphSession | null | undefined;
            if (value && typeof value.edit === 'function' && 'snapshot' in value) return value;
          }
      throw new Error('no component above the bar has a graph session');
    });
    const session = handle as JSHandle<GraphSession & { account: Account }>;
    await session.evaluate((s) => {
      const shared = s['shared'];
      const connection = s['connection'];
      const account = { made: [] as (readonly Edit[])[], refused: 0, sessions: [] as number[] };
      const { add, refused } = shared;
      shared.add = (own) => {
        add.call(shared, own);
        account.made.push(shared['pending'].at(-1)?.own.edits ?? []);
      };
      shared.refused = (again = false) => {
        if (!again && shared['sent']) account.refused++;
        refused.call(shared, again);
      };
      const note = (): void => {
        if (connection.state.kind === 'open') account.sessions.push(connection.state.welcome.session);
      };
      note();
      connection.onState(note);
      s.account = account;
    });
    return new PageSession(page, session);
  }

  // Documents and edits cross to the page as text, since their types are too deep for playwright's.
  document(): Promise<JsonObject> {
    return this.session
      .evaluate((s) => JSON.stringify(s.snapshot.document))
      .then((text) => JSON.parse(text) as JsonObject);
  }
  /** Returns whether the edits could be applied to what the page shows. */
  edit(edits: readonly Edit[]): Promise<boolean> {
    const text = JSON.stringify(edits);
    return this.session.evaluate((s, e) => s.edit(JSON.parse(e) as Edit[]), text);
  }
  /** How many own edits the server has not ordered yet. */
  waiting(): Promise<number> {
    return this.session.evaluate((s) => s.snapshot.waiting);
  }
  revision(): Promise<number> {
    return this.session.evaluate((s) => s.snapshot.revision);
  }
  isConnected(): Promise<boolean> {
    return this.session.evaluate((s) => s['connection'].state.kind === 'open');
  }
  account(): Promise<Account> {
    return this.session.evaluate((s) => s.account);
  }
  press(button: 'Undo' | 'Redo'): Promise<void> {
    return this.page.getByRole('button', { name: button, exact: true }).dispatchEvent('click');
  }
}
