// SPDX-License-Identifier: Apache-2.0
import { StrictMode } from 'react';
import { createRoot } from 'react-dom/client';
import { App } from './app';
import './theme.css';

const root = document.getElementById('root');
if (!root) throw new Error('index.html: there is no element `root`');
createRoot(root).render(
  <StrictMode>
    <App />
  </StrictMode>,
);
