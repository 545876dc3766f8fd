// SPDX-License-Identifier: Apache-2.0
// The newest frame of a window, and what is said of it.

export interface Frame {
  number: number;
  shown: boolean; // its first pass is
  scale: number;
  pass: number;
  ended: boolean;
  lossless: boolean;
  status: string;
  error: string;
  seconds: number;
}

export const NO_FRAME: Frame = {
  ...{ number: 0, shown: false, scale: 0, pass: 0, ended: false, lossless: false },
  ...{ status: '', error: '', seconds: 0 },
};

/** A view of a graph has nothing to show, and so no camera that is fitted to it. */
export class NothingThereYet extends Error {
  override readonly message = 'nothing of what it shows is there yet ...';
}

export interface WindowStatus {
  /** For people; an error begins with "error: ". */
  text: string;
  /** Whether the picture is that of the newest camera with all its passes. */
  whole: boolean;
  /** Of the newest frame: whether its pixels are without loss, how many passes of how many. */
  lossless: boolean;
  pass: number;
  passes: number;
  /** That all its passes took; 0 until they are there. */
  seconds: number;
  generations: Record<string, number>;
}

interface OfWindow {
  isReady: boolean;
  /** Newer data are not shown by themselves. */
  isHeld: boolean;
  passes: number;
  /** What the server says while it prepares something. */
  progress: string;
  /** Of the window, or of what was asked for last. */
  error: string;
}

/** Whether a frame has failed since newer data have taken the place of its own. */
const isPushedOut = (error: string): boolean => error.includes('needs the room of generation');

const NO_GRAPH = /\bgraph ("(?:[^"\\]|\\.)*"): there is none\b/;

/** What the server refuses, and what to do on the page, where the server's words are of its verbs. */
export function refusalText(error: string): string {
  const graph = NO_GRAPH.exec(error)?.[1];
  return graph === undefined
    ? error
    : `the server has no graph ${graph}. Press "Make it again" above the graph, and it is as this page knows it.`;
}

/** For people; an error begins with "error: ". */
export function statusText(frame: Frame, { isReady, isHeld, passes, progress, error }: OfWindow): string {
  const why = error || (frame.ended && frame.status === 'failed' ? frame.error : '');
  if (progress) return progress;
  const shown = `${frame.pass + 1} of ${passes} passes`;
  // Newer data have taken the place of these. They are shown next, if the picture is not held.
  const isOver = isHeld || isPushedOut(frame.error);
  if (isOver && frame.shown && frame.scale === 1 && frame.status === 'failed') return `lossless, ${shown}`;
  if (why) return `error: ${refusalText(why)}`;
  if (!isReady) return 'loading data ...';
  if (frame.number === 0) return 'waiting for the first picture ...';
  if (!frame.lossless) {
    const coarse = frame.scale > 1 ? `, 1 of ${frame.scale} x ${frame.scale} pixels` : '';
    return `moving: JPEG${coarse}`;
  }
  if (frame.scale !== 1) return 'rendering ...';
  if (!frame.ended) return `lossless, refining: ${shown}`;
  return `lossless, ${shown}, ${frame.seconds.toFixed(2)} s`;
}
