// SPDX-License-Identifier: Apache-2.0
// What keys do in a view: those of docs/viewer.md, and arrows, which turn.
import { useOverlays } from '../overlay/overlay_state';
import { seriesShown } from '../steps/series_store';
import type { View } from './view';

export interface Key {
  keys: string[];
  help: string;
  /** What each of `keys` does, in their order. */
  actions: ((view: View) => void)[];
}

const TURN = 5; // degrees

export const KEYS: Key[] = [
  {
    keys: ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown'],
    help: 'turn by 5 degrees',
    actions: [
      (view) => {
        view.turn(TURN, 0);
      },
      (view) => {
        view.turn(-TURN, 0);
      },
      (view) => {
        view.turn(0, -TURN);
      },
      (view) => {
        view.turn(0, TURN);
      },
    ],
  },
  {
    keys: ['+', '-'],
    help: 'nearer, farther',
    actions: [
      (view) => {
        view.wheel(1);
      },
      (view) => {
        view.wheel(-1);
      },
    ],
  },
  {
    keys: ['r'],
    help: 'all data in view',
    actions: [
      (view) => {
        view.reset();
      },
    ],
  },
  {
    keys: ['b'],
    help: 'back to the camera of the file',
    actions: [
      (view) => {
        view.back();
      },
    ],
  },
  {
    keys: ['x', 'y', 'z'],
    help: 'look along an axis',
    actions: ([0, 1, 2] as const).map((axis) => (view) => {
      view.lookAlong(axis, 1);
    }),
  },
  {
    keys: ['X', 'Y', 'Z'],
    help: 'look against an axis',
    actions: ([0, 1, 2] as const).map((axis) => (view) => {
      view.lookAlong(axis, -1);
    }),
  },
  {
    keys: ['v', 'V'],
    help: 'next, previous visualization of the file',
    actions: ([1, -1] as const).map((by) => (view) => {
      view.nextVisualization(by);
    }),
  },
  {
    keys: ['c', 'C'],
    help: 'next, previous camera of the file',
    actions: ([1, -1] as const).map((by) => (view) => {
      view.nextCamera(by);
    }),
  },
  {
    keys: ['k'],
    help: 'hold the picture, or follow newer data again',
    actions: [
      (view) => {
        view.hold(!view.status.held);
      },
    ],
  },
  {
    keys: [',', '.'],
    help: 'previous, next step of a series of files',
    actions: ([-1, 1] as const).map((by) => (view) => {
      for (const series of seriesShown(view)) series.goTo(series.state.wanted + by);
    }),
  },
  {
    keys: ['<', '>'],
    help: 'its first, its last step',
    actions: ([false, true] as const).map((isLast) => (view) => {
      for (const series of seriesShown(view)) series.goTo(isLast ? series.steps.length - 1 : 0);
    }),
  },
  {
    keys: ['Space'],
    help: 'play the series, or stop',
    actions: [
      (view) => {
        for (const series of seriesShown(view)) series.play(!series.state.isPlaying);
      },
    ],
  },
  {
    keys: ['s'],
    help: 'spin, on and off',
    actions: [
      (view) => {
        view.turnSpin();
      },
    ],
  },
  {
    keys: ['a'],
    help: 'legend, axes and box of the data, on and off',
    actions: [
      () => {
        useOverlays.getState().toggleAnnotations();
      },
    ],
  },
  {
    keys: ['g'],
    help: 'handles of slices and clip planes, on and off',
    actions: [
      () => {
        useOverlays.getState().toggle('handles');
      },
    ],
  },
];

/** Does what a key does in the view. Returns whether it does anything. */
export function press(view: View, key: string): boolean {
  for (const { keys, actions } of KEYS) {
    const action = actions[keys.indexOf(key === ' ' ? 'Space' : key)];
    if (!action) continue;
    action(view);
    return true;
  }
  return false;
}
