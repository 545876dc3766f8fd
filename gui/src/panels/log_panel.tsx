// SPDX-License-Identifier: Apache-2.0
// Events and errors of the graph that is open, as text that can be copied.
import { useEffect, useRef } from 'react';
import { printable } from '../app/foreign';
import { useSnapshot } from '../canvas/graph_store';

export function LogPanel() {
  const log = useSnapshot()?.log ?? [];
  const end = useRef<HTMLLIElement>(null);
  useEffect(() => {
    end.current?.scrollIntoView({ block: 'nearest' }); // Some browsers return a promise, which no effect may do.
  }, [log.length]);
  if (log.length === 0) return <p className="empty">Nothing has happened yet.</p>;
  return (
    <ol className="log" aria-label="Log of the graph">
      {log.map((line, i) => (
        <li
          key={`${line.at} ${i}`}
          className={line.isError ? 'error' : undefined}
          ref={i === log.length - 1 ? end : null}
        >
          <time>{new Date(line.at).toLocaleTimeString()}</time> <bdi>{printable(line.text)}</bdi>
        </li>
      ))}
    </ol>
  );
}
