// SPDX-License-Identifier: Apache-2.0
// The places of the page: toolbar at the top, graph left, properties below it, views right, status line at the bottom.
import type { ReactNode } from 'react';
import './layout.css';
import { Split } from './split';

export interface LayoutProps {
  top: ReactNode;
  graph: ReactNode;
  properties: ReactNode;
  views: ReactNode;
  status: ReactNode;
}

export function Layout({ top, graph, properties, views, status }: LayoutProps) {
  return (
    <div className="layout">
      <header>{top}</header>
      <Split direction="row" name="Width of the graph" initial={0.45}>
        <Split direction="column" name="Height of the graph" initial={0.6}>
          <section className="place" aria-label="Graph">
            {graph}
          </section>
          <section className="place" aria-label="Properties">
            {properties}
          </section>
        </Split>
        <main className="place" aria-label="Views">
          {views}
        </main>
      </Split>
      <footer className="status" aria-label="Status">
        {status}
      </footer>
    </div>
  );
}
