// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { type Browser, forgetToken, keepToken, takeCredential } from './credentials';

function browserAt(hash: string) {
  const kept = new Map<string, string>();
  const addresses: string[] = [];
  const browser: Browser = {
    location: { hash, pathname: '/', search: '' },
    history: {
      replaceState: (_data, _unused, url) => {
        addresses.push(url);
      },
    },
    sessionStorage: {
      getItem: (key) => kept.get(key) ?? null,
      setItem: (key, value) => void kept.set(key, value),
      removeItem: (key) => void kept.delete(key),
    },
  };
  return { browser, addresses };
}

it('the ticket is taken out of the address, and what else the fragment says stays there', () => {
  const { browser, addresses } = browserAt('#view=above&ticket=a-b_c');
  expect(takeCredential(browser)).toEqual({ ticket: 'a-b_c' });
  expect(addresses).toEqual(['/#view=above']);
  const alone = browserAt('#ticket=abc');
  takeCredential(alone.browser);
  expect(alone.addresses).toEqual(['/']);
});

it('without a ticket it is the token that the tab has kept, until that is forgotten', () => {
  const { browser, addresses } = browserAt('');
  expect(takeCredential(browser)).toBeNull();
  keepToken(browser, 'secret');
  expect(takeCredential(browser)).toEqual({ token: 'secret' });
  forgetToken(browser);
  expect(takeCredential(browser)).toBeNull();
  expect(addresses).toEqual([]);
});
