// SPDX-License-Identifier: Apache-2.0
// The page's worker: it has the socket, decodes what comes, and paints.
import { Channel, type Message } from '../wire/header';
import { parseObject } from '../wire/json';
import { decodeRecord } from '../wire/records';
import { Link } from './link';
import type { FromWorker, ToWorker } from './messages';
import { Windows } from './windows';

const post = (message: FromWorker, transfer: Transferable[] = []) => {
  postMessage(message, { transfer });
};
const windows = new Windows(post);
let link: Link | null = null;
let hidden = false;

function take({ channel, id, payload }: Message): void {
  switch (channel) {
    case Channel.Reply:
      post({ kind: 'reply', id, text: new TextDecoder().decode(payload) });
      break;
    case Channel.Event:
      post({ kind: 'event', text: new TextDecoder().decode(payload) });
      break;
    case Channel.Pixels:
      windows.take(decodeRecord(payload));
      break;
    case Channel.File:
      takeFile(id, payload);
      break;
    default:
      throw new Error(`message: channel ${channel}, expected 2 to 5`);
  }
}

function takeFile(id: number, payload: Uint8Array<ArrayBuffer>): void {
  const length = new DataView(payload.buffer, payload.byteOffset).getUint32(0, true);
  const object = parseObject(new TextDecoder().decode(payload.subarray(4, 4 + length)), 'file record');
  const content = payload.slice(4 + length);
  post({ kind: 'file', id, object, content }, [content.buffer]);
}

function connect({ url, credential, client }: Extract<ToWorker, { kind: 'connect' }>): void {
  link?.close();
  windows.restart();
  link = new Link(url, credential, client, {
    onOpen: (welcome, token) => {
      post({ kind: 'open', welcome, token });
    },
    onRefused: (reason) => {
      post({ kind: 'refused', reason });
    },
    onClosed: (reason) => {
      post({ kind: 'closed', reason });
    },
    onSilent: (seconds) => {
      post({ kind: 'silent', seconds });
    },
    onMessage: take,
  });
  link.setHidden(hidden);
}

addEventListener('message', ({ data }: MessageEvent<ToWorker>) => {
  switch (data.kind) {
    case 'connect':
      connect(data);
      break;
    case 'disconnect':
      link?.close();
      break;
    case 'request':
      link?.request(data.id, data.text);
      break;
    case 'hidden':
      hidden = data.hidden;
      link?.setHidden(hidden);
      break;
    case 'window':
      windows.add(data.window, data.canvas, data.width, data.height);
      break;
    case 'size':
      windows.resize(data.window, data.width, data.height);
      break;
    case 'forget':
      windows.forget(data.window);
      break;
    case 'png':
      void windows.png(data.window, data.call);
      break;
  }
});
