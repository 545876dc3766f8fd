// SPDX-License-Identifier: Apache-2.0
// A picture with all its rays, made in a window of the server of its own while the view goes on.
import type { Connection } from '../wire/connection';
import { statement } from '../wire/statement';
import { type Camera, cameraJson, type Size } from './camera';
import type { Pictures } from './pictures';
import type { Shown } from './remote_window';

interface Wanted {
  shown: Shown;
  camera: Camera;
  size: Size;
  passes: number;
}

/** Returns it as PNG. Rejects with the server's reason if there is none. */
export async function still(
  connection: Connection,
  pictures: Pictures,
  { shown, camera, size, passes }: Wanted,
): Promise<Uint8Array<ArrayBuffer>> {
  const window = pictures.newWindow();
  let end: (error: string) => void = () => undefined;
  const ended = new Promise<string>((resolve) => {
    end = resolve;
  });
  const stopWatching = connection.onState(() => {
    end('the connection is lost');
  });
  pictures.open(window, null, size, {
    onPass: () => undefined,
    onEnded: ({ status, error }) => {
      end(status === 'complete' ? '' : `the picture could not be made (${status}): ${error}`);
    },
    onBroken: end,
  });
  try {
    const { width, height } = size;
    const set =
      shown.kind === 'document'
        ? statement('viewer.set', [window], shown.document)
        : statement('viewer.show', [window], { graph: shown.graph, view: shown.view });
    // All rays are in one pass: newer data end a frame that has one, as it has a picture to show.
    const render = { Camera: cameraJson(camera), levels: [1], rays: passes, passes: 1 };
    await Promise.all([
      connection.request(statement('viewer.window', [window], { size: [width, height] })),
      connection.request(set),
    ]);
    await connection.request(statement('viewer.render', [window], render)); // What it shows has to be there before.
    const error = await ended;
    if (error) throw new Error(error);
    return await pictures.png(window);
  } finally {
    stopWatching();
    pictures.close(window);
    if (connection.state.kind === 'open')
      connection.request(statement('viewer.close', [window])).catch(() => undefined);
  }
}
