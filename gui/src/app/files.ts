// SPDX-License-Identifier: Apache-2.0
// Files of the user's own machine.

const KEPT = 60_000; // milliseconds

/** Has the browser save a file. */
export function download(name: string, content: BlobPart, type: string): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = document.createElement('a');
  link.href = url;
  link.download = name;
  link.click();
  // The browser may read it only after this turn.
  setTimeout(() => {
    URL.revokeObjectURL(url);
  }, KEPT);
}

/** The name of a file without its folder and what stands behind the last dot. */
export function stem(name: string): string {
  return (
    (name.split(/[/\\]/).pop() ?? name)
      .replace(/\.[^.]*$/, '')
      .replace(/[*?"<>|:]/g, '')
      .trim() || 'galaxy'
  );
}
