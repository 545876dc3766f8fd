// SPDX-License-Identifier: Apache-2.0
import type { Camera } from './camera';

/**
 * From which camera each frame is made. Frames that the server makes by itself, since data or looks have changed, are made from the camera
 * of the last frame before them that was asked for.
 */
export class FrameCameras {
  private known: { frame: number; camera: Camera }[] = []; // ascending

  /** Takes the camera of a frame that was asked for, and whose number the server has told. */
  add(frame: number, camera: Camera): void {
    this.known.push({ frame, camera });
  }

  /** The camera of a frame; null if it is not known yet. Frames before it are forgotten. */
  of(frame: number): Camera | null {
    const older = this.known.filter((entry) => entry.frame <= frame);
    const last = older[older.length - 1];
    if (last) this.known = [last, ...this.known.filter((entry) => entry.frame > frame)];
    return last?.camera ?? null;
  }
}
