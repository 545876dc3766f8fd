// SPDX-License-Identifier: Apache-2.0
// Light or dark: as the system is, unless the user has chosen.
import { create } from 'zustand';

type Theme = 'system' | 'light' | 'dark';

interface ThemeState {
  theme: Theme;
  next(): void;
}

const KEY = 'galaxy.theme';
const ORDER: Theme[] = ['system', 'light', 'dark'];

function apply(theme: Theme): void {
  if (theme === 'system') delete document.documentElement.dataset['theme'];
  else document.documentElement.dataset['theme'] = theme;
}

export const useTheme = create<ThemeState>((set, get) => ({
  theme: 'system',
  next() {
    const theme = ORDER[(ORDER.indexOf(get().theme) + 1) % ORDER.length] ?? 'system';
    localStorage.setItem(KEY, theme);
    apply(theme);
    set({ theme });
  },
}));

/** Takes what was chosen before. */
export function restoreTheme(): void {
  const theme = ORDER.find((known) => known === localStorage.getItem(KEY)) ?? 'system';
  apply(theme);
  useTheme.setState({ theme });
}
