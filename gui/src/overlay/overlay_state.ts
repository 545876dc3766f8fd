// SPDX-License-Identifier: Apache-2.0
// Which overlays the page shows over its pictures: the same for all views.
import { create } from 'zustand';

export const OVERLAYS = ['box', 'axes', 'legend', 'handles'] as const;
export type OverlayName = (typeof OVERLAYS)[number];

interface OverlayState extends Record<OverlayName, boolean> {
  toggle(name: OverlayName): void;
  /** Takes legend, axes and box away if any of them is shown, else brings all three back. */
  toggleAnnotations(): void;
}

export const useOverlays = create<OverlayState>((set) => ({
  ...{ box: true, axes: true, legend: true, handles: true },
  toggle(name) {
    set((state) => ({ [name]: !state[name] }));
  },
  toggleAnnotations() {
    set(({ box, axes, legend }) => {
      const isOn = !(box || axes || legend);
      return { box: isOn, axes: isOn, legend: isOn };
    });
  },
}));
