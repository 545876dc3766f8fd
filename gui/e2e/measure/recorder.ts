// SPDX-License-Identifier: Apache-2.0
// When things happen in a page, by the page's own clock: what it says to its worker, what the worker tells, and where the mouse goes.
import type { Page } from 'playwright-core';
import type { FromWorker, ToWorker } from '../../src/worker/messages';

export interface PassRecord {
  /** When the page was told that it was painted. */
  readonly at: number;
  readonly frame: number;
  readonly pass: number;
  /** Of rendering. */
  readonly seconds: number;
  /** The newest of its data. */
  readonly generation: number;
}

/** Milliseconds since the page was begun. */
export interface Record {
  readonly opened: readonly number[];
  readonly requests: readonly { at: number; id: number; text: string }[];
  readonly replies: readonly { at: number; id: number; text: string }[];
  readonly events: readonly { at: number; text: string }[];
  readonly passes: readonly PassRecord[];
  readonly moves: readonly number[];
  /** Of each picture that the browser has drawn of the page. */
  readonly frames: readonly number[];
}

/** Records in each document that the page will show. */
export async function recordIn(page: Page): Promise<void> {
  await page.addInitScript(() => {
    const kept = {
      opened: [] as number[],
      requests: [] as object[],
      replies: [] as object[],
      events: [] as object[],
      passes: [] as object[],
      moves: [] as number[],
      frames: [] as number[],
    };
    Object.assign(window, { kept });
    const take = ({ data }: MessageEvent<FromWorker>): void => {
      const at = performance.now();
      if (data.kind === 'open') kept.opened.push(at);
      else if (data.kind === 'reply') kept.replies.push({ at, id: data.id, text: data.text });
      else if (data.kind === 'event') kept.events.push({ at, text: data.text });
      else if (data.kind === 'pass') {
        const { frame, pass, seconds, generations } = data.pass;
        const generation = Math.max(0, ...Object.values(generations));
        kept.passes.push({ at, frame, pass, seconds, generation });
      }
    };
    window.Worker = class extends Worker {
      constructor(url: string | URL, options?: WorkerOptions) {
        super(url, options);
        this.addEventListener('message', take);
      }
      override postMessage(message: ToWorker, more?: Transferable[] | StructuredSerializeOptions): void {
        if (message.kind === 'request')
          kept.requests.push({ at: performance.now(), id: message.id, text: message.text });
        super.postMessage(message, more as Transferable[]);
      }
    };
    addEventListener('pointermove', (event) => kept.moves.push(event.timeStamp), true);
    const drawn = (at: number): void => {
      kept.frames.push(at);
      requestAnimationFrame(drawn);
    };
    requestAnimationFrame(drawn);
  });
}

/** What was recorded since the document was begun. */
export const recorded = (page: Page): Promise<Record> =>
  page.evaluate(() => (window as unknown as { kept: Record }).kept);

/** When data got new generations, by what the page was told. */
export const updates = ({ events }: Record): { at: number; generation: number }[] =>
  events
    .map(({ at, text }) => ({ at, ...(JSON.parse(text) as { event: string; generation: number }) }))
    .filter(({ event }) => event === 'updated');

/** The page's clock. */
export const clock = (page: Page): Promise<number> => page.evaluate(() => performance.now());

/** Milliseconds between the pictures of the page from one time to another. */
export function frameTimes({ frames }: Record, from: number, to: number): number[] {
  const drawn = frames.filter((at) => at >= from && at <= to);
  return drawn.slice(1).map((at, i) => at - (drawn[i] ?? at));
}

/**
 * The frames that were asked for while something moved (as JPEG) and painted from one time to another: when, and how long after the last
 * motion of the mouse before each was asked for.
 */
export function movingFrames(record: Record, from: number, to: number): { at: number; latency: number }[] {
  const askedAt = new Map(
    record.requests.flatMap(({ at, id, text }): [number, number][] =>
      text.startsWith('viewer.render') && text.includes('"jpeg"') ? [[id, at]] : [],
    ),
  );
  const askedOf = new Map<number, number>();
  for (const { id, text } of record.replies) {
    const frame = /"frame":\s*(\d+)/.exec(text)?.[1];
    const at = askedAt.get(id);
    if (frame !== undefined && at !== undefined) askedOf.set(Number(frame), at);
  }
  const seen = new Set<number>();
  return record.passes.flatMap(({ at, frame }) => {
    const asked = askedOf.get(frame);
    if (seen.has(frame) || asked === undefined || at < from || at > to) return [];
    seen.add(frame);
    const move = record.moves.filter((m) => m <= asked).at(-1);
    return move === undefined ? [] : [{ at, latency: at - move }];
  });
}
