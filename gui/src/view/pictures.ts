// SPDX-License-Identifier: Apache-2.0
// What views see of the worker that decodes and paints.
import type { FrameEnded, PassShown } from '../worker/messages';
import type { Size } from './camera';

export interface PictureHandlers {
  onPass(pass: PassShown): void;
  onEnded(frame: FrameEnded): void;
  /** Pixels came that cannot be decoded. */
  onBroken(error: string): void;
}

/** All on the main thread. A window's number is the server's, and unique on the page. */
export interface Pictures {
  newWindow(): number;
  /** Paints what comes for the window into the canvas, which nobody else touches from now on; null: keeps the picture only. */
  open(window: number, canvas: OffscreenCanvas | null, size: Size, handlers: PictureHandlers): void;
  resize(window: number, size: Size): void;
  close(window: number): void;
  /** The last picture without loss, with the server's pixels to the bit, as PNG. Rejects if there is none. */
  png(window: number): Promise<Uint8Array<ArrayBuffer>>;
}
