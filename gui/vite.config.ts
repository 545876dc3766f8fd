// SPDX-License-Identifier: Apache-2.0
/// <reference types="vitest/config" />
import react from '@vitejs/plugin-react';
import { defineConfig } from 'vite';

export default defineConfig({
  plugins: [react()],
  build: {
    target: 'es2022',
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0, // The server's content security policy allows files only.
  },
  worker: { format: 'es' },
  test: { include: ['src/**/*.test.{ts,tsx}'], testTimeout: 60_000 },
});
