// SPDX-License-Identifier: Apache-2.0
import { Foreign } from './foreign';
import { useNotices } from './notices';

/** Shows notices, and has screen readers say them. */
export function NoticeList() {
  const { notices, dismiss } = useNotices();
  return (
    <div className="notices" role="status" aria-live="polite">
      {notices.map(({ id, text, error }) => (
        <div key={id} className={error ? 'notice notice-error' : 'notice'}>
          <span>
            {error && 'Error: '}
            <Foreign text={text} />
          </span>
          <button
            type="button"
            className="plain"
            aria-label="Close this message"
            onClick={() => {
              dismiss(id);
            }}
          >
            ×
          </button>
        </div>
      ))}
    </div>
  );
}
