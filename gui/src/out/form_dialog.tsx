// SPDX-License-Identifier: Apache-2.0
// A form in a window over the page, and fields of it.
import { type ReactNode, useEffect, useId, useRef } from 'react';
import './out.css';

interface FormDialogProps {
  readonly title: string;
  readonly onClose: () => void;
  /** Of Enter, and of the button that does it. */
  readonly onSubmit: () => void;
  readonly children: ReactNode;
}

export function FormDialog({ title, onClose, onSubmit, children }: FormDialogProps) {
  const dialog = useRef<HTMLDialogElement>(null);
  const heading = useId();
  useEffect(() => {
    dialog.current?.showModal();
  }, []);
  return (
    <dialog ref={dialog} className="out-form" aria-labelledby={heading} onClose={onClose}>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          onSubmit();
        }}
      >
        <h2 id={heading}>{title}</h2>
        {children}
      </form>
    </dialog>
  );
}

interface NumberTextProps {
  readonly label: string;
  readonly value: string;
  readonly onChange: (text: string) => void;
  /** What is wrong with it; empty: nothing. */
  readonly problem?: string | undefined;
}

/** A field for a number. What is typed stays as it is, so that it can be mended. */
export function NumberText({ label, value, onChange, problem = '' }: NumberTextProps) {
  const id = useId();
  return (
    <p className="out-field">
      <label htmlFor={id}>{label}</label>
      <input
        id={id}
        inputMode="decimal"
        autoComplete="off"
        value={value}
        aria-invalid={problem !== ''}
        aria-describedby={`${id}-problem`}
        onChange={(event) => onChange(event.target.value)}
      />
      <span id={`${id}-problem`} className="error">
        {problem}
      </span>
    </p>
  );
}

interface TextLineProps {
  readonly label: string;
  readonly value: string;
  readonly onChange: (text: string) => void;
  readonly note: string;
}

export function TextLine({ label, value, onChange, note }: TextLineProps) {
  const id = useId();
  return (
    <p className="out-field">
      <label htmlFor={id}>{label}</label>
      <input
        id={id}
        autoComplete="off"
        spellCheck={false}
        className="out-wide"
        value={value}
        aria-describedby={`${id}-note`}
        onChange={(event) => onChange(event.target.value)}
      />
      <span id={`${id}-note`} className="weak">
        {note}
      </span>
    </p>
  );
}

/** What is wrong with a text that is to be a whole number in a range; empty: nothing. */
export function wholeProblem(text: string, least: number, most: number): string {
  const isWhole = /^\d+$/.test(text.trim());
  return isWhole && Number(text) >= least && Number(text) <= most ? '' : `expected ${least} to ${most}`;
}
