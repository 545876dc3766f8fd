// SPDX-License-Identifier: Apache-2.0
// The views of the page, and which of them is in front.
import { create } from 'zustand';
import type { Connection } from '../wire/connection';
import type { Pictures } from './pictures';
import { type Source, View } from './view';

interface Views {
  views: View[];
  /** The id of the view in front; 0 if there is none. */
  active: number;
  /** Opens a view in front of the others. */
  add(title: string, source: Source, server: Connection & Pictures): View;
  activate(id: number): void;
  close(id: number): void;
}

let last = 0;

export const useViews = create<Views>((set, get) => ({
  views: [],
  active: 0,
  add(title, source, server) {
    const view = new View(++last, title, source, server, server);
    set(({ views }) => ({ views: [...views, view], active: view.id }));
    return view;
  },
  activate(id) {
    set({ active: id });
  },
  close(id) {
    const { views, active } = get();
    const at = views.findIndex((view) => view.id === id);
    views[at]?.detach();
    const left = views.filter((view) => view.id !== id);
    const next = left[Math.min(at, left.length - 1)]?.id ?? 0;
    set({ views: left, active: active === id ? next : active });
  },
}));
