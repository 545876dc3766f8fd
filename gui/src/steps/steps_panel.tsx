// SPDX-License-Identifier: Apache-2.0
// The publishers: which step each has come to, and how far the view in front is behind it.
import { Foreign } from '../app/foreign';
import { secondsText } from '../graph/states';
import type { View } from '../view/view';
import { useViews } from '../view/views';
import type { Publisher } from './publishers';
import './steps.css';
import { useSteps } from './steps_store';
import { useStepsShown } from './use_steps_shown';

function Lamp({ publisher }: { readonly publisher: Publisher }) {
  const { isLive, connected, ranks } = publisher;
  if (!isLive) return <span className="lamp lamp-warn">ended</span>;
  if (connected < ranks)
    return (
      <span className="lamp lamp-warn">
        {connected} of {ranks} ranks
      </span>
    );
  return <span className="lamp lamp-good">live</span>;
}

function Row({ publisher, behind }: { readonly publisher: Publisher; readonly behind: number | undefined }) {
  const { name, step, time, secondsPerStep, leftOut, problem } = publisher;
  return (
    <tr>
      <th scope="row">
        <Foreign text={name} />
        {problem !== '' && (
          <p className="error">
            <Foreign text={problem} />
          </p>
        )}
      </th>
      <td>
        <Lamp publisher={publisher} />
      </td>
      <td className="number">{step ?? 'none'}</td>
      <td className="number">{time === undefined ? '' : Number(time.toPrecision(6))}</td>
      <td className="number">{secondsPerStep === undefined ? '' : secondsText(secondsPerStep)}</td>
      <td className="number">{behind ?? ''}</td>
      <td className="number">{leftOut}</td>
    </tr>
  );
}

function Table({ behind }: { readonly behind: ReadonlyMap<string, number> }) {
  const publishers = useSteps((s) => s.publishers);
  return (
    <table className="data-list">
      <thead>
        <tr>
          <th scope="col">Publisher</th>
          <th scope="col">State</th>
          <th scope="col" className="number">
            Step
          </th>
          <th scope="col" className="number">
            Time
          </th>
          <th scope="col" className="number" title="Between two steps of the simulation">
            A step takes
          </th>
          <th scope="col" className="number" title="How many steps the view in front shows less">
            Behind
          </th>
          <th scope="col" className="number" title="Steps that the server wanted and could not take">
            Left out
          </th>
        </tr>
      </thead>
      <tbody>
        {publishers.map((publisher) => (
          <Row key={publisher.name} publisher={publisher} behind={behind.get(publisher.name)} />
        ))}
      </tbody>
    </table>
  );
}

function TableOf({ view }: { readonly view: View }) {
  const shown = useStepsShown(view);
  return <Table behind={new Map(shown.map(({ publisher, behind }) => [publisher, behind]))} />;
}

export function StepsPanel() {
  const count = useSteps((s) => s.publishers.length);
  const front = useViews(({ views, active }) => views.find(({ id }) => id === active));
  if (count === 0) return <p className="empty">No simulation publishes to this server.</p>;
  return front ? <TableOf key={front.id} view={front} /> : <Table behind={new Map()} />;
}
