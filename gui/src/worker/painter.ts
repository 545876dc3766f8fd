// SPDX-License-Identifier: Apache-2.0
// The picture of one window: its pixels without loss, and the canvas that shows it.
import { Encoding, type PixelRecord } from '../wire/records';
import { decodeJpeg, decodeLossless } from './decode';
import type { Pass } from './passes';
import { encodePng } from './png';

/** Pixels from top to bottom, as canvases have them. */
class Picture {
  readonly image: ImageData;
  constructor(
    readonly width: number,
    readonly height: number,
  ) {
    this.image = new ImageData(width, height);
  }

  /** Copies a tile, whose rows go from bottom to top. */
  put(tile: PixelRecord, pixels: Uint8Array): void {
    const row = tile.w * 4;
    for (let y = 0; y < tile.h; y++) {
      const to = ((this.height - 1 - tile.y - y) * this.width + tile.x) * 4;
      this.image.data.set(pixels.subarray(y * row, (y + 1) * row), to);
    }
  }
}

export class Painter {
  private readonly context: OffscreenCanvasRenderingContext2D | null;
  private whole: Picture | null = null; // the last lossless pass in the window's size
  private gathered: Picture | null = null; // of a lossless pass that is coming
  private level: OffscreenCanvas | null = null; // of a JPEG pass, and of coarse levels

  constructor(
    private readonly canvas: OffscreenCanvas | null,
    private width: number,
    private height: number,
  ) {
    this.context = canvas ? canvas.getContext('2d', { alpha: false }) : null;
    this.resize(width, height);
  }

  /** The picture that is there is stretched until another comes. */
  resize(width: number, height: number): void {
    this.width = width;
    this.height = height;
    this.whole = this.gathered = null;
    if (!this.canvas || !this.context || (this.canvas.width === width && this.canvas.height === height))
      return;
    const before = new OffscreenCanvas(this.canvas.width, this.canvas.height);
    before.getContext('2d')?.drawImage(this.canvas, 0, 0);
    this.canvas.width = width;
    this.canvas.height = height;
    this.context.drawImage(before, 0, 0, width, height);
  }

  /** Whether a pass is of the window's present size. */
  fits({ width, height, scale }: Pass): boolean {
    return width === Math.ceil(this.width / scale) && height === Math.ceil(this.height / scale);
  }

  /** Throws an Error if the tile cannot be decoded. `jpeg` is its bitmap if it was begun to be decoded before. */
  async paint(pass: Pass, tile: PixelRecord, jpeg: Promise<ImageBitmap> | undefined): Promise<void> {
    if (tile.encoding === Encoding.Jpeg) {
      const bitmap = await (jpeg ?? decodeJpeg(tile));
      if (this.fits(pass)) this.paintFlipped(bitmap, pass, tile);
      bitmap.close();
      return;
    }
    const pixels = await decodeLossless(tile);
    if (!this.fits(pass)) return;
    if (pass.scale === 1) {
      this.gathered ??= new Picture(this.width, this.height);
      this.gathered.put(tile, pixels);
      return;
    }
    const picture = new Picture(tile.w, tile.h);
    picture.put({ ...tile, x: 0, y: 0 }, pixels);
    this.levelOf(pass)?.putImageData(picture.image, tile.x, pass.height - tile.y - tile.h);
  }

  /** Shows a pass, all of whose tiles are painted; one with a broken tile is left out. Returns whether the picture is now one without loss in the window's size. */
  show(pass: Pass): boolean {
    if (!this.fits(pass) || pass.broken) return false;
    if (pass.lossless && pass.scale === 1) {
      [this.whole, this.gathered] = [this.gathered, this.whole];
      if (this.whole) this.context?.putImageData(this.whole.image, 0, 0);
      return this.whole !== null;
    }
    if (!this.context || !this.level) return false;
    // A level is in the middle of the window, and its smaller dimension spans as much as the window's.
    const by = Math.min(this.width, this.height) / Math.min(pass.width, pass.height);
    const [w, h] = [pass.width * by, pass.height * by];
    this.context.imageSmoothingQuality = 'medium';
    this.context.drawImage(this.level, (this.width - w) / 2, (this.height - h) / 2, w, h);
    return false;
  }

  /** The last picture without loss. Throws an Error if there is none. */
  async png(): Promise<Uint8Array<ArrayBuffer>> {
    if (!this.whole) throw new Error('screenshot: there is no picture without loss yet');
    const { image, width, height } = this.whole;
    return encodePng(image.data.slice(), width, height);
  }

  private levelOf(pass: Pass): OffscreenCanvasRenderingContext2D | null {
    if (this.level?.width !== pass.width || this.level.height !== pass.height)
      this.level = new OffscreenCanvas(pass.width, pass.height);
    return this.level.getContext('2d', { alpha: false });
  }

  private paintFlipped(bitmap: ImageBitmap, pass: Pass, tile: PixelRecord): void {
    const context = this.levelOf(pass);
    if (!context) return;
    context.setTransform(1, 0, 0, -1, 0, pass.height);
    context.drawImage(bitmap, tile.x, tile.y);
    context.setTransform(1, 0, 0, 1, 0, 0);
  }
}
