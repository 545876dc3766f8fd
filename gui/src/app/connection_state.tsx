// SPDX-License-Identifier: Apache-2.0
// What the user sees of the connection: the form to connect, the bar when it is lost, and the status line's part.
import { type FormEvent, useEffect, useState } from 'react';
import type { Credential } from '../wire/handshake';
import { Foreign } from './foreign';
import { useConnectionState, useServer, useSilence } from './server';

/** A ticket has 43 characters of base64url; all else is a token. */
function credentialOf(text: string): Credential {
  return /^[\w-]{43}$/.test(text) ? { ticket: text } : { token: text };
}

function Problem({ problem }: { problem: string }) {
  return (
    <>
      The server says: <Foreign text={problem} />.
    </>
  );
}

function TokenForm() {
  const server = useServer();
  const [text, setText] = useState('');
  function submit(event: FormEvent) {
    event.preventDefault();
    server.connect(credentialOf(text.trim()));
  }
  return (
    <form className="token" onSubmit={submit}>
      <label>
        Token
        <input
          type="password"
          autoComplete="off"
          spellCheck={false}
          value={text}
          onChange={(event) => {
            setText(event.target.value);
          }}
        />
      </label>
      <button type="submit" className="primary">
        Connect
      </button>
    </form>
  );
}

/** The whole page as long as nobody has connected. */
export function ConnectPage({ problem }: { problem: string }) {
  return (
    <main className="connect">
      <div>
        <h1>Galaxy</h1>
        {problem && (
          <p role="alert" className="error">
            <Problem problem={problem} />
          </p>
        )}
        <p>
          Open the address that <code>galaxy gui</code> prints. Each address counts once. Instead, you can
          enter the server’s token, which is in the file that the server names.
        </p>
        <TokenForm />
      </div>
    </main>
  );
}

function Countdown({ until }: { until: number }) {
  const [now, setNow] = useState(() => Date.now());
  useEffect(() => {
    const timer = setInterval(() => {
      setNow(Date.now());
    }, 250);
    return () => {
      clearInterval(timer);
    };
  }, []);
  return <>{Math.max(0, (until - now) / 1000).toFixed(1)} s</>;
}

/** Lies over the page while the server is not there; the views keep their size, and so their pictures. */
export function LossBar() {
  const state = useConnectionState();
  const server = useServer();
  const silence = useSilence();
  if (state.kind === 'lost')
    return (
      <div className="loss" role="alert">
        <span>
          <strong>Not connected.</strong> <Foreign text={state.reason} />. Next try in{' '}
          <Countdown until={state.retryAt} />
        </span>
        <button
          type="button"
          onClick={() => {
            server.connectNow();
          }}
        >
          Try now
        </button>
      </div>
    );
  if (state.kind === 'connecting' && state.before)
    return (
      <div className="loss" role="alert">
        <strong>Not connected.</strong> Connecting ...
      </div>
    );
  if (state.kind === 'locked')
    return (
      <div className="loss">
        <span role="alert">
          <strong>Not connected.</strong> The server lets this page in no more, as after it was started again.
          Open the address that <code>galaxy gui</code> prints, or enter its new token.{' '}
          <Problem problem={state.problem} />
        </span>
        <TokenForm />
      </div>
    );
  if (silence > 0)
    return (
      <div className="loss" role="alert">
        The server has not answered for {Math.floor(silence)} s.
      </div>
    );
  return null;
}

export function ConnectionStatus() {
  const state = useConnectionState();
  switch (state.kind) {
    case 'open':
      return (
        <>
          <span className="lamp lamp-good">Connected</span>
          <span>
            <Foreign text={state.welcome.server} />
          </span>
          <span>{state.welcome.ranks === 1 ? '1 rank' : `${state.welcome.ranks} ranks`}</span>
          <span title="A tenant is a user or a project of the server. It has data and graphs of its own, which other tenants do not see, and its share of the memory.">
            tenant <Foreign text={state.welcome.tenant} />
          </span>
          {state.welcome.viewOnly && <span>view only</span>}
        </>
      );
    case 'connecting':
      return <span className="lamp lamp-warn">Connecting ...</span>;
    default:
      return <span className="lamp lamp-bad">Not connected</span>;
  }
}
