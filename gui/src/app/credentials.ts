// SPDX-License-Identifier: Apache-2.0
// What proves who the user is. The page gets a ticket in its URL's fragment, which browsers send to nobody, and keeps the token
// that the server gives for it until the tab is closed. The token is in no address, history or other storage.
import type { Credential } from '../wire/handshake';

const KEY = 'galaxy.token';

/** The part of the browser that this needs; tests have one of their own. */
export interface Browser {
  location: { hash: string; pathname: string; search: string };
  history: { replaceState(data: unknown, unused: string, url: string): void };
  sessionStorage: Pick<Storage, 'getItem' | 'setItem' | 'removeItem'>;
}

/** Takes the ticket out of the address bar. Returns it, else the tab's token, else null. */
export function takeCredential(browser: Browser): Credential | null {
  const fragment = new URLSearchParams(browser.location.hash.slice(1));
  const ticket = fragment.get('ticket');
  if (ticket !== null) {
    fragment.delete('ticket');
    const rest = fragment.toString();
    const { pathname, search } = browser.location;
    browser.history.replaceState(null, '', pathname + search + (rest ? `#${rest}` : ''));
    return { ticket };
  }
  const token = browser.sessionStorage.getItem(KEY);
  return token === null ? null : { token };
}

export function keepToken(browser: Browser, token: string): void {
  browser.sessionStorage.setItem(KEY, token);
}

export function forgetToken(browser: Browser): void {
  browser.sessionStorage.removeItem(KEY);
}
