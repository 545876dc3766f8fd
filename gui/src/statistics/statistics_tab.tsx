// SPDX-License-Identifier: Apache-2.0
// Loads the statistics when their tab is opened for the first time: few look at them, and the charts are a library of their own.
import { type ComponentType, useEffect, useState } from 'react';
import { messageOf } from '../graph/session';

export function StatisticsTab() {
  const [loaded, setLoaded] = useState<{ Panel?: ComponentType; problem?: string }>({});
  useEffect(() => {
    let isWanted = true;
    import('./statistics_panel').then(
      ({ StatisticsPanel }) => {
        if (isWanted) setLoaded({ Panel: StatisticsPanel });
      },
      (error: unknown) => {
        if (isWanted) setLoaded({ problem: messageOf(error) });
      },
    );
    return () => {
      isWanted = false;
    };
  }, []);
  const { Panel, problem } = loaded;
  if (Panel) return <Panel />;
  if (problem === undefined) return <p className="empty">Loading ...</p>;
  return (
    <p className="empty">
      The charts cannot be loaded ({problem}). Open the tab again once the server is there.
    </p>
  );
}
