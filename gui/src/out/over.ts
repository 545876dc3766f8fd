// SPDX-License-Identifier: Apache-2.0

/** Lays pixels over others of the same size, in place. Colours are not multiplied by opacity; what is under nothing stays as it is. */
export function over(below: Uint8ClampedArray, above: Uint8ClampedArray): void {
  for (let i = 0; i < below.length; i += 4) {
    const opacity = (above[i + 3] ?? 0) / 255;
    if (opacity === 0) continue;
    const rest = ((below[i + 3] ?? 0) / 255) * (1 - opacity);
    const sum = opacity + rest;
    for (let c = i; c < i + 3; c++) below[c] = ((above[c] ?? 0) * opacity + (below[c] ?? 0) * rest) / sum;
    below[i + 3] = 255 * sum;
  }
}
