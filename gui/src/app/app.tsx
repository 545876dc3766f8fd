// SPDX-License-Identifier: Apache-2.0
// The page: which part is at which place.
import { Layout } from './layout';

export function App() {
  return (
    <Layout
      graph={<p className="empty">No graph is open.</p>}
      properties={<p className="empty">Nothing is selected.</p>}
      views={<p className="empty">No view is open.</p>}
      status={<span>Not connected</span>}
    />
  );
}
