// SPDX-License-Identifier: Apache-2.0
// Keeps track of the frames that a window has asked for and that have not come yet, as tools/gxyviewer/frames_asked.h does.
import type { Camera } from './camera';
import type { Detail } from './pace';

export interface Asked {
  readonly camera: Camera;
  /** Of the frame, if the camera is moving; null: at rest. */
  readonly moving: Detail | null;
  /** Known once the server has replied. */
  number: number | null;
}

/**
 * The frames that have been asked for and of which nothing has been shown yet. The server's replies give their numbers and
 * come in the order of the requests. Pixels and the end of a frame may come before its number.
 */
export class FramesAsked {
  private asked: Asked[] = [];
  private newestNumber = 0;
  private doneNumber = 0;
  private readonly skipped = new Set<number>(); // of which no request is known

  ask(camera: Camera, moving: Detail | null): void {
    this.asked.push({ camera, moving, number: null });
  }

  /** Takes the number in the reply to the oldest request without a reply. */
  number(frame: number): void {
    const oldest = this.oldestWithoutReply();
    if (!oldest) return;
    oldest.number = frame;
    this.newestNumber = Math.max(this.newestNumber, frame);
    if (frame <= this.doneNumber || this.skipped.delete(frame)) this.remove(oldest);
  }

  /** The server has refused the oldest request without a reply. */
  refuse(): void {
    const oldest = this.oldestWithoutReply();
    if (oldest) this.remove(oldest);
  }

  /** The request of a frame; undefined if this window has not asked for it or does not know its number yet. */
  find(frame: number): Asked | undefined {
    return this.asked.find((asked) => asked.number === frame);
  }

  /** Something of `frame` is shown, or it has ended. Nothing of older frames will be shown any more. */
  done(frame: number): void {
    this.doneNumber = Math.max(this.doneNumber, frame);
    this.newestNumber = Math.max(this.newestNumber, frame);
    this.asked = this.asked.filter((asked) => asked.number === null || asked.number > frame);
  }

  /** `frame` was superseded before it began. The frame before it is still to come. */
  skip(frame: number): void {
    if (!this.find(frame)) this.skipped.add(frame);
    this.newestNumber = Math.max(this.newestNumber, frame);
    this.asked = this.asked.filter((asked) => asked.number !== frame);
  }

  get underWay(): number {
    return this.asked.length;
  }

  /** The newest frame that the server has numbered. */
  get newest(): number {
    return this.newestNumber;
  }

  private oldestWithoutReply(): Asked | undefined {
    return this.asked.find((asked) => asked.number === null);
  }

  private remove(asked: Asked): void {
    this.asked = this.asked.filter((other) => other !== asked);
  }
}
