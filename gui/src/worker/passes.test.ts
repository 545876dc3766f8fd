// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { Encoding, Kind, type PixelRecord } from '../wire/records';
import { PassQueue } from './passes';

const record = (kind: Kind, frame: number, rest: Partial<PixelRecord> = {}): PixelRecord => ({
  ...{ kind, frame, window: 1, width: 8, height: 8, scale: 1, pass: 0 },
  ...{ x: 0, y: 0, w: 8, h: 8, encoding: Encoding.Zstd, data: new Uint8Array(10) },
  ...rest,
});
const tile = (frame: number, rest: Partial<PixelRecord> = {}) => record(Kind.Tile, frame, rest);
const endOfPass = (frame: number, rest: Partial<PixelRecord> = {}) => record(Kind.EndOfPass, frame, rest);
const endOfFrame = (frame: number) => record(Kind.EndOfFrame, frame, { pass: 0 });

/** What the queue has to do now, in words. */
function all(queue: PassQueue): string[] {
  const done: string[] = [];
  for (let work = queue.next(); work; work = queue.next())
    done.push(
      work.kind === 'end'
        ? `end ${work.record.frame}`
        : `${work.kind} ${work.pass.frame}.${work.pass.scale}.${work.pass.pass}`,
    );
  return done;
}

function take(queue: PassQueue, ...records: PixelRecord[]): void {
  for (const one of records) queue.take(one, 0);
}

it('tiles are painted as they come, and shown once all have come', () => {
  const queue = new PassQueue();
  take(queue, tile(1), tile(1, { x: 8 }));
  expect(all(queue)).toEqual(['tile 1.1.0', 'tile 1.1.0']);
  take(queue, endOfPass(1), endOfFrame(1));
  expect(all(queue)).toEqual(['show 1.1.0', 'end 1']);
});

it('passes are left out of which a later one has come, but not one that has been begun', () => {
  const queue = new PassQueue();
  take(queue, tile(1));
  expect(queue.next()?.kind).toBe('tile');
  take(queue, endOfPass(1), tile(1, { pass: 1 }), endOfPass(1, { pass: 1 }));
  take(queue, tile(1, { pass: 2 }), endOfPass(1, { pass: 2 }), endOfFrame(1));
  expect(all(queue)).toEqual(['show 1.1.0', 'skip 1.1.1', 'tile 1.1.2', 'show 1.1.2', 'end 1']);
});

it('a pass whose frame is superseded gives way to the newer frame', () => {
  const queue = new PassQueue();
  take(queue, tile(1), tile(2), endOfFrame(1), endOfPass(2));
  expect(all(queue)).toEqual(['tile 1.1.0', 'tile 2.1.0', 'show 2.1.0', 'end 1']);
});

it('the end of a frame that never began overtakes the pass that is still coming', () => {
  const queue = new PassQueue();
  take(queue, tile(1), endOfFrame(2));
  expect(all(queue)).toEqual(['tile 1.1.0', 'end 2']);
  take(queue, endOfPass(1), endOfFrame(1));
  expect(all(queue)).toEqual(['show 1.1.0', 'end 1']);
});

it('an end without any pass ends its frame, and what was begun of it is forgotten', () => {
  const queue = new PassQueue();
  take(queue, endOfFrame(1), tile(2), endOfFrame(2), tile(3), endOfPass(3));
  expect(all(queue)).toEqual(['end 1', 'tile 2.1.0', 'end 2', 'tile 3.1.0', 'show 3.1.0']);
});

it('a pass is without loss if no tile of it is JPEG, and the speed of the link is that of what came after the first tile', () => {
  const queue = new PassQueue();
  queue.take(tile(1, { encoding: Encoding.Jpeg }), 5);
  queue.take(tile(1, { data: new Uint8Array(30) }), 7);
  queue.take(endOfPass(1), 9);
  const pass = queue.next();
  expect(pass).toMatchObject({
    pass: { lossless: false, bytes: 40, firstBytes: 10, begin: 5, endedAt: 9 },
  });
});

it('tiles that are left out are told', () => {
  const left: PixelRecord[] = [];
  const queue = new PassQueue((one) => left.push(one));
  const [first, second] = [tile(1), tile(1, { pass: 1 })];
  take(queue, first, endOfPass(1), second, endOfPass(1, { pass: 1 }));
  expect(all(queue)).toEqual(['skip 1.1.0', 'tile 1.1.1', 'show 1.1.1']);
  expect(left).toEqual([first]);
});
