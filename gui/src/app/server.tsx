// SPDX-License-Identifier: Apache-2.0
// The page's connection, for components.
import { createContext, type ReactNode, useContext, useEffect, useState, useSyncExternalStore } from 'react';
import type { ConnectionState } from '../wire/connection';
import type { ServerConnection } from './server_connection';

const Context = createContext<ServerConnection | null>(null);

export function ServerProvider({ server, children }: { server: ServerConnection; children: ReactNode }) {
  return <Context value={server}>{children}</Context>;
}

export function useServer(): ServerConnection {
  const server = useContext(Context);
  if (!server) throw new Error('useServer: there is no ServerProvider above');
  return server;
}

export function useConnectionState(): ConnectionState {
  const server = useServer();
  return useSyncExternalStore(
    (changed) => server.onState(changed),
    () => server.state,
  );
}

/** Seconds since which the server does not answer; 0: it does. */
export function useSilence(): number {
  const server = useServer();
  const [seconds, setSeconds] = useState(0);
  useEffect(() => server.onSilent(setSeconds), [server]);
  return seconds;
}
