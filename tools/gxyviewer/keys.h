// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace gxy {

/// The help text for the mouse and keys of the window. Key h and option --help show it.
inline constexpr const char* kKeyHelp =
    "  left drag            rotate\n"
    "  middle, shift + left pan\n"
    "  right drag, wheel    zoom\n"
    "  ctrl + left          roll\n"
    "  r                    reset: all data in view\n"
    "  b                    back to the file's camera\n"
    "  x y z (X Y Z)        look along an axis (against it)\n"
    "  v (V)                next (previous) visualization\n"
    "  c (C)                next (previous) camera of the file\n"
    "  o (O)                next (previous) operator, for these:\n"
    "  - +  [ ]  0          its data range: narrow, widen; move; reset\n"
    "  , .                  previous, next time step of a series\n"
    "  < >, Home, End       its first, its last\n"
    "  space                play the steps from here on, stop\n"
    "  i                    what is under the mouse, its value\n"
    "  a                    legend, axes and the data's box, on and off\n"
    "  s                    spin, on and off\n"
    "  w                    write camera and state to PREFIX.json\n"
    "  p                    save a whole picture: PREFIX_00000.png\n"
    "  h                    this help, on and off\n"
    "  q                    quit";

}  // namespace gxy
