#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""terminal.py COMMAND...: a client at a terminal (pseudo-terminal) of a server that has a dataset eightBalls: Tab
completes a verb wherever one may be, and names of data and of modules after one, the arrow up brings the last line back,
also that of the session before, a statement may go over lines, # begins a comment, Ctrl-C forgets what was typed or cancels
what runs, events come above the line that is being typed, long work shows how far it is, Ctrl-D ends it."""
import json
import os
import pty
import select
import subprocess
import sys
import tempfile
import time

said = ""  # by the program, and not waited for yet


def until(text, seconds=30):
    """Waits for the program to write `text`."""
    global said
    end = time.monotonic() + seconds
    while text not in said:
        if not select.select([terminal], [], [], max(end - time.monotonic(), 0))[0]:
            sys.exit(f"no {text!r} within {seconds} s, but {said!r}")
        try:
            said += os.read(terminal, 4096).decode()
        except OSError:  # it has ended
            sys.exit(f"ended without {text!r}: {said!r}")
    said = said.split(text, 1)[1]


def untilItWaits(seconds=30):
    """Waits until the server has not answered something that another client than the one which asks here has sent."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        stat = subprocess.run([*sys.argv[1:], "--json", "-c", "stat;"], check=True, capture_output=True).stdout
        clients = json.loads(stat)["reply"]["clients"]
        asking = max(c["session"] for c in clients)
        if any(c["requests"] > 0 for c in clients if c["session"] != asking):
            return
    sys.exit(f"nothing runs within {seconds} s, and there was said {said!r}")


def start():
    global process, terminal
    process, terminal = pty.fork()
    if process == 0:
        os.environ["TERM"] = "dumb"
        os.execv(sys.argv[1], sys.argv[1:])
    until("? ")


def end(expected=0):
    os.write(terminal, b"\x04")
    status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
    if status != expected:
        sys.exit(f"exit status {status}, expected {expected}")


folder = tempfile.TemporaryDirectory()
os.environ["XDG_STATE_HOME"] = folder.name
start()
for typed, answers in [(b"lis\t", ["list "]), (b";\n", ["eightBalls", "? "]), (b"\x1b[A", ["list ;"]),
                       (b"\n", ["eightBalls", "? "]), (b"info\n", ["> "]), (b"eightBalls;\n", ["24", "? "])]:
    os.write(terminal, typed)
    for answer in answers:
        until(answer)
# Verbs of a module that was loaded meanwhile, with its name, and after another statement. Ctrl-U forgets the line.
os.write(terminal, b"load viewer;\n")
until("? ")
for typed, answer in [(b"cancel_f\t", "cancel_frame "), (b"viewer.sta\t", "viewer.state "), (b"list; unp\t", "unpublish "),
                      (b"info eightB\t", "info eightBalls "), (b"load vie\t", "load viewer ")]:
    os.write(terminal, typed)
    until(answer)
    os.write(terminal, b"\x15")
load = 'import {"Datasets": {"name": "seen", "type": "Volume", "filename": "eightBalls.vol"}}'
os.write(terminal, b"observe;\n")
until("? ")
os.write(terminal, b"li")
until("li")
subprocess.run([*sys.argv[1:], "-c", load], check=True)
until("event: added seen, private Volume, generation 1")
until("? li")
os.write(terminal, b"st;\n")
for answer in ["datasets:", "seen", "? "]:
    until(answer)
os.write(terminal, load.encode() + b";\n")
for answer in ["event: updated seen, private Volume, generation 2", "done: 100 of 100", "? "]:
    until(answer)
os.write(terminal, b"drop seen;\n")
for answer in ["event: dropped seen", "? "]:
    until(answer)
# A second session. Ctrl-C is pressed in a line, in a statement of two, and while one runs.
end()
start()
for typed, answers in [(b"\x1b[A", ["drop seen;"]), (b"\x03", ["? "]), (b"no such\n", ["> "]), (b"thing", ["thing"]), (b"\x03", ["? "]),
                       (b"  # no; such; thing;\n", ["? "]), (b"wait never;\n", ["wait never;"])]:
    os.write(terminal, typed)
    for answer in answers:
        until(answer)
    if "no such" in said:
        sys.exit(f"what was to be forgotten was sent: {said!r}")
untilItWaits()  # before, it would be forgotten as a line is
for typed, answers in [(b"\x03", ["error: cancelled", "? "]), (b"list;\n", ["eightBalls", "? "])]:
    os.write(terminal, typed)
    for answer in answers:
        until(answer)
end(1)  # one has failed
