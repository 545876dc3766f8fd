// SPDX-License-Identifier: Apache-2.0
import { CinemaForm } from './cinema_form';
import { useForms } from './forms';
import { PictureForm } from './picture_form';

/** The form that is open, if one is. */
export function OutForms() {
  const { open, close } = useForms();
  if (!open) return null;
  const Form = open.kind === 'picture' ? PictureForm : CinemaForm;
  return <Form view={open.view} onClose={close} />;
}
