# SPDX-License-Identifier: Apache-2.0
"""A display without a screen, Xvfb: its mouse and keys through xdotool, its pixels from the file it keeps them in."""
import os
import pathlib
import subprocess
import tempfile

import numpy as np


class Display:
    def __init__(self, xvfb, xdotool, width=640, height=480):
        self._xdotool = xdotool
        self._temporary = tempfile.TemporaryDirectory(prefix="galaxy-display-")
        self._pixels = pathlib.Path(self._temporary.name) / "Xvfb_screen0"
        read, write = os.pipe()
        self._process = subprocess.Popen(
            [xvfb, "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-noreset", "-nolisten", "tcp",
             "-fbdir", self._temporary.name], pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as number:
            self.environment = {**os.environ, "DISPLAY": ":" + number.readline().strip()}

    def do(self, *words):
        """One line of xdotool's, as do("mousemove", 10, 20, "click", 1)."""
        subprocess.run([self._xdotool, *map(str, words)], env=self.environment, check=True, stdout=subprocess.DEVNULL)

    def drag(self, button, start, by, keys=()):
        """Presses a button at `start`, moves in ten steps by `by` (pixels right and down), lets go."""
        self.do("mousemove", *start, *(word for key in keys for word in ("keydown", key)), "mousedown", button)
        for step in range(1, 11):
            self.do("mousemove", *(s + b * step // 10 for s, b in zip(start, by)))
        self.do("mouseup", button, *(word for key in keys for word in ("keyup", key)))

    def screen(self, width, height):
        """uint8 (height, width, 3) of the upper left corner, row 0 at the top. XWD version 7, 32 bits a pixel."""
        file = self._pixels.read_bytes()
        header = np.frombuffer(file, ">u4", 25)
        line, rows, start = int(header[12]), int(header[5]), int(header[0] + 12 * header[19])
        pixels = np.frombuffer(file, np.uint8, line * rows, start).reshape(rows, line // 4, 4)
        return pixels[:height, :width, 2::-1].copy()

    def stop(self):
        self._process.terminate()
        self._process.wait(30)
        self._temporary.cleanup()
