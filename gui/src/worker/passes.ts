// SPDX-License-Identifier: Apache-2.0
// What is to be done with the pixel records of one window, in which order. Records come faster than they can be decoded at
// times: then passes are left out, of which a later one has come wholly, but never one that has been begun, so that there is
// always something to see. No pixels are touched here.
import { Encoding, Kind, type PixelRecord } from '../wire/records';

/** The tiles of a pass of a level of a frame, as far as they have come. */
export interface Pass {
  readonly frame: number;
  readonly scale: number;
  readonly pass: number;
  readonly width: number;
  readonly height: number;
  /** Those that are still to be painted. */
  tiles: PixelRecord[];
  bytes: number;
  readonly begin: number; // when the first record came, milliseconds
  readonly firstBytes: number;
  /** Set once all tiles have come. */
  end: PixelRecord | null;
  endedAt: number;
  begun: boolean;
  /** None of its tiles is JPEG. */
  lossless: boolean;
  /** A tile of it could not be decoded. */
  broken: boolean;
}

export type Work =
  | { kind: 'tile'; pass: Pass; tile: PixelRecord }
  /** All tiles of the pass are painted. */
  | { kind: 'show'; pass: Pass }
  /** A later pass has come already. */
  | { kind: 'skip'; pass: Pass }
  | { kind: 'end'; record: PixelRecord };

export class PassQueue {
  private readonly items: (Pass | PixelRecord)[] = [];

  /** `onLeft` gets each tile that will not be painted, as far as next() leaves it out. */
  constructor(private readonly onLeft: (tile: PixelRecord) => void = () => undefined) {}

  /** Takes a record that came at the time `now`, in milliseconds. */
  take(record: PixelRecord, now: number): void {
    if (record.kind === Kind.EndOfFrame) {
      this.items.push(record);
      return;
    }
    const pass = this.passOf(record, now);
    if (record.kind === Kind.Tile) {
      pass.tiles.push(record);
      pass.lossless &&= record.encoding !== Encoding.Jpeg;
      pass.bytes += record.data.length;
    } else {
      pass.end = record;
      pass.endedAt = now;
    }
  }

  /** The next thing to do; null if more has to come first. */
  next(): Work | null {
    for (;;) {
      const first = this.items[0];
      if (!first) return null;
      if (!isPass(first)) {
        this.items.shift();
        return { kind: 'end', record: first };
      }
      if (
        first.end &&
        !first.begun &&
        this.items.some((item) => item !== first && isPass(item) && item.end)
      ) {
        this.leave(first);
        return { kind: 'skip', pass: first };
      }
      const tile = first.tiles.shift();
      if (tile) {
        first.begun = true;
        return { kind: 'tile', pass: first, tile };
      }
      if (first.end) {
        this.items.shift();
        return { kind: 'show', pass: first };
      }
      // The server drops what is left of a pass when a newer frame begins.
      if (this.items.some((item) => isPass(item) && item.frame > first.frame)) this.leave(first);
      else return this.endBehind(first);
    }
  }

  // The end of a frame that was overtaken before it began may stand behind a pass that is still coming.
  private endBehind(pass: Pass): Work | null {
    const at = this.items.findIndex((item) => !isPass(item));
    const record = this.items[at];
    if (!record || isPass(record)) return null;
    this.items.splice(at, 1);
    if (record.frame === pass.frame) this.leave(pass); // its tiles will not come any more
    return { kind: 'end', record };
  }

  private leave(pass: Pass): void {
    this.items.splice(this.items.indexOf(pass), 1);
    pass.tiles.forEach(this.onLeft);
  }

  private passOf(record: PixelRecord, now: number): Pass {
    for (const item of this.items)
      if (
        isPass(item) &&
        item.frame === record.frame &&
        item.scale === record.scale &&
        item.pass === record.pass
      )
        return item;
    const { frame, scale, pass, width, height, data } = record;
    const made: Pass = {
      ...{ frame, scale, pass, width, height, begin: now, firstBytes: data.length },
      ...{ tiles: [], bytes: 0, end: null, endedAt: 0, begun: false, lossless: true },
      broken: false,
    };
    this.items.push(made);
    return made;
  }
}

const isPass = (item: Pass | PixelRecord): item is Pass => 'tiles' in item;
