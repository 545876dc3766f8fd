// SPDX-License-Identifier: Apache-2.0
// The window on the user's display: VTK's interaction moves the camera, the server's pictures fill it.
#pragma once
#include <functional>
#include <optional>

#include "tools/gxyviewer/remote_window.h"
#include "tools/gxyviewer/selection.h"
#include "tools/gxyviewer/series.h"

namespace gxy {

/// A state that is to be shown instead, if there is one. Asked often; throws Error for one that is not whole or not right.
using NewerState = std::function<std::optional<State>()>;

/// Shows `remote` until the user quits. It shows `selection`, of which the user may choose another part and which is saved with
/// the camera as it is then, and whose data are those of the first step of `series`; `output` is the prefix of the files;
/// `annotated`: whether annotations are drawn at first. Throws Error where there is no display that can show it, and when the
/// server has gone or could not show the state.
void runViewer(RemoteWindow& remote, Selection selection, Series series, const std::string& output,
               bool annotated, NewerState newer);

/// Throws Error, with what to do, unless a window can be opened. VTK itself would end the process.
void checkDisplay();

}  // namespace gxy
