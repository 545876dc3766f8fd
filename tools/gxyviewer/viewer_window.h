// SPDX-License-Identifier: Apache-2.0
// The window on the user's display. VTK's interaction moves the camera, and the server renders the pictures.
#pragma once
#include <functional>
#include <optional>

#include "tools/gxyviewer/remote_window.h"
#include "tools/gxyviewer/selection.h"
#include "tools/gxyviewer/series.h"

namespace gxy {

/// Returns a newer state to show, if there is one. It is called often. Throws Error for a state file that is
/// incomplete or wrong.
using NewerState = std::function<std::optional<State>()>;

/// Shows `remote` until the user quits. `remote` shows `selection`, whose data are those of the first step of
/// `series`. The user can select other parts, and save the state with the present camera. `output` is the
/// prefix of saved files. `annotated`: annotations are drawn initially. Throws Error if no display can show
/// the window, and when the server has gone or cannot show the state.
void runViewer(RemoteWindow& remote, Selection selection, Series series, const std::string& output,
               bool annotated, NewerState newer);

/// Throws Error, with advice, unless a window can be opened. VTK itself would end the process.
void checkDisplay();

}  // namespace gxy
