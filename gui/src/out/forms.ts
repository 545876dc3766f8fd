// SPDX-License-Identifier: Apache-2.0
// Which form of what leaves the page is open, and for which view.
import { create } from 'zustand';
import type { View } from '../view/view';

export type FormKind = 'picture' | 'cinema';

interface Forms {
  readonly open: { readonly kind: FormKind; readonly view: View } | undefined;
  show(kind: FormKind, view: View): void;
  close(): void;
}

export const useForms = create<Forms>((set) => ({
  open: undefined,
  show(kind, view) {
    set({ open: { kind, view } });
  },
  close() {
    set({ open: undefined });
  },
}));
