# SPDX-License-Identifier: Apache-2.0
"""Tests of the package gxy against a real server. A test program is started with PROGRAMS MPIEXEC..., as the other tests of clients."""
import os
import pathlib
import subprocess
import sys
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]
sys.path[:0] = [str(SOURCE / folder) for folder in ("tests/clients", "python/src")]
import gxy  # noqa: E402
from server import Server  # noqa: E402


class OnRanks:
    """A server on `ranks` ranks for a class of tests, and a session for each test. What a test leaves is dropped after it."""

    ranks = 1

    @classmethod
    def setUpClass(cls):
        cls.server = Server(PROGRAMS, MPIEXEC, cls.ranks)
        cls.addClassCleanup(cls.stop)

    @classmethod
    def stop(cls):
        with cls.connect() as session:
            session.ask("quit")
        status = cls.server.stop()
        assert status == 0, f"the server ended with status {status} after quit"

    @classmethod
    def connect(cls, **options):
        return gxy.connect(f"localhost:{cls.server.port}", str(cls.server.token), **options)

    def setUp(self):
        self.session = self.connect()
        self.addCleanup(self.clean)

    def clean(self):
        for name in self.session.graphs:
            self.session.graph(name).drop()
        for data in self.session:
            data.drop()
        self.session.close()

    def balls(self, array="eightBalls"):
        """A volume of 24 x 24 x 24 points from -1 to 1."""
        return self.session.open("balls.vti", array=array, name=array)

    def run_here(self, program, *arguments):
        """Runs a program in the server's folder of data. What it prints."""
        done = subprocess.run([PROGRAMS / program, *map(str, arguments)], cwd=self.server.folder, capture_output=True, text=True,
                              env={**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def assert_same_picture(self, picture, file):
        """Compares a Picture with a PNG file of the server's folder, to the bit."""
        picture.save(self.server.folder / "of_python.png")
        self.run_here("gxydiff", "--alpha", "of_python.png", file)

    def assert_no_thread_left(self, before):
        import threading
        self.assertEqual(set(threading.enumerate()) - set(before), set())


def main():
    unittest.main(argv=sys.argv[:1], verbosity=2)
