// SPDX-License-Identifier: Apache-2.0
// Which step a view shows, and the button that holds it there.
import { Foreign } from '../app/foreign';
import type { View } from '../view/view';
import './steps.css';
import { useStepsShown } from './use_steps_shown';

export function StepLine({ view, isHeld }: { readonly view: View; readonly isHeld: boolean }) {
  const shown = useStepsShown(view);
  const hint = isHeld
    ? 'Show newer data by themselves again (k)'
    : 'Keep this picture: newer data are not shown (k)';
  return (
    <>
      {shown.map(({ publisher, step, time, behind }) => (
        <span key={publisher} className="step-shown">
          {shown.length > 1 && (
            <>
              <Foreign text={publisher} />{' '}
            </>
          )}
          step {step}
          {time !== undefined && `, time ${Number(time.toPrecision(6))}`}
          {behind > 0 && `, ${behind} behind`}
        </span>
      ))}
      {isHeld && <strong className="held">held</strong>}
      {(isHeld || shown.length > 0) && (
        <button
          type="button"
          className="hold"
          title={view.whyNotHeld === '' ? hint : view.whyNotHeld}
          aria-pressed={isHeld}
          disabled={view.whyNotHeld !== ''}
          onClick={() => view.hold(!isHeld)}
        >
          Hold
        </button>
      )}
    </>
  );
}
