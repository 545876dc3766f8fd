// SPDX-License-Identifier: Apache-2.0
import { StrictMode } from 'react';
import { createRoot } from 'react-dom/client';
import { App } from './app';
import { forgetToken, keepToken, takeCredential } from './credentials';
import { ServerProvider } from './server';
import { ServerConnection } from './server_connection';
import './theme.css';
import './controls.css';
import { restoreTheme } from './theme';

const credential = takeCredential(window); // before anything else sees the address
const root = document.getElementById('root');
if (!root) throw new Error('index.html: there is no element `root`');
restoreTheme();

const worker = new Worker(new URL('../worker/main.ts', import.meta.url), { type: 'module' });
const server = new ServerConnection(worker, `${location.origin.replace(/^http/, 'ws')}/ws`, (token) => {
  if (token === null) forgetToken(window);
  else keepToken(window, token);
});
if (credential) server.connect(credential);
document.addEventListener('visibilitychange', () => {
  server.setHidden(document.visibilityState === 'hidden');
});

createRoot(root).render(
  <StrictMode>
    <ServerProvider server={server}>
      <App />
    </ServerProvider>
  </StrictMode>,
);
