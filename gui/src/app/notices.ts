// SPDX-License-Identifier: Apache-2.0
// Short messages to the user.
import { create } from 'zustand';

export interface Notice {
  id: number;
  text: string;
  error: boolean;
}

interface Notices {
  notices: Notice[];
  say(text: string): void;
  /** Says what went wrong; `error` is what was thrown. It stays until the user closes it. */
  fail(error: unknown): void;
  dismiss(id: number): void;
}

const MOST = 5;
const SHOWN_FOR = 4000; // milliseconds
let last = 0;

export const useNotices = create<Notices>((set, get) => {
  const add = (text: string, error: boolean) => {
    const id = ++last;
    set(({ notices }) => ({ notices: [...notices, { id, text, error }].slice(-MOST) }));
    return id;
  };
  return {
    notices: [],
    say(text) {
      const id = add(text, false);
      setTimeout(() => {
        get().dismiss(id);
      }, SHOWN_FOR);
    },
    fail(error) {
      add(error instanceof Error ? error.message : String(error), true);
    },
    dismiss(id) {
      set(({ notices }) => ({ notices: notices.filter((notice) => notice.id !== id) }));
    },
  };
});
