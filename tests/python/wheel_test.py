# SPDX-License-Identifier: Apache-2.0
"""wheel_test.py PROGRAMS MPIEXEC...: a wheel is built of python/ without network, installed into an empty folder, and used from
there. Without pip, setuptools and wheel, which Debian has as python3-pip, python3-setuptools and python3-wheel, it is skipped (status 77)."""
import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(SOURCE / "tests/clients")]
from server import Server  # noqa: E402

PROGRAMS, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]
USE = """
import pathlib, sys, gxy
assert pathlib.Path(gxy.__file__).is_relative_to(sys.argv[1]), gxy.__file__
assert "numpy" not in sys.modules and "gxy.session" not in sys.modules
with gxy.connect(sys.argv[2], sys.argv[3]) as session:
    balls = session.open("balls.vti", array="oneBall", name="balls")
    graph = session.graph("g")
    picture = graph.view(graph.volume(balls, isovalues=[0.5])).render(size=(40, 30))
    assert picture.array.shape == (30, 40, 4)
    print(balls.values().shape, picture)
    session.ask("quit")
"""


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        temporary = tempfile.TemporaryDirectory(prefix="galaxy-wheel-")
        cls.addClassCleanup(temporary.cleanup)
        cls.folder = pathlib.Path(temporary.name)
        shutil.copytree(SOURCE / "python", cls.folder / "python", ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"))
        cls.pip("wheel", "--no-build-isolation", "--no-deps", "--no-index", "-w", "wheels", "python/")
        cls.wheel, = (cls.folder / "wheels").iterdir()
        cls.pip("install", "--no-deps", "--no-index", "--target", "installed", cls.wheel)

    @classmethod
    def pip(cls, *arguments):
        done = subprocess.run([sys.executable, "-m", "pip", "--disable-pip-version-check", *arguments], cwd=cls.folder,
                              capture_output=True, text=True, timeout=200)
        assert done.returncode == 0, done.stdout + done.stderr

    def run_installed(self, *arguments):
        environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
        done = subprocess.run([sys.executable, "-B", *arguments], cwd=self.folder, capture_output=True, text=True, timeout=200,
                              env={**environment, "PYTHONPATH": str(self.folder / "installed")})
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_it_holds_all_modules_and_nothing_else(self):
        modules = {f"gxy/{path.name}" for path in (SOURCE / "python/src/gxy").iterdir() if path.suffix in (".py", ".typed")}
        with zipfile.ZipFile(self.wheel) as wheel:
            names = {name for name in wheel.namelist() if ".dist-info/" not in name}
            about = wheel.read(next(name for name in wheel.namelist() if name.endswith("METADATA"))).decode()
        self.assertEqual(names, modules)
        self.assertIn("gxy/py.typed", names)
        for line in ("Name: gxy", "Requires-Python: >=3.9", "Requires-Dist: numpy", "Provides-Extra: mpi"):
            self.assertIn(line, about)

    def test_it_works_where_it_is_installed(self):
        server = Server(PROGRAMS, MPIEXEC, 1)
        try:
            said = self.run_installed("-c", USE, self.folder / "installed", f"localhost:{server.port}", server.token)
        finally:
            self.assertEqual(server.stop(), 0)
        self.assertEqual(said.strip(), "(24, 24, 24) <Picture 40 x 30>")

    def test_its_version_is_galaxys(self):
        galaxy = subprocess.run([PROGRAMS / "gxyserver", "--version"], capture_output=True, text=True).stdout.split()[1]
        self.assertEqual(self.run_installed("-m", "gxy", "--version").split(), ["gxy", galaxy])
        self.assertTrue(self.wheel.name.startswith(f"gxy-{galaxy}-py3-none-any"), self.wheel.name)


if __name__ == "__main__":
    missing = [name for name in ("pip", "setuptools", "wheel") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"skipped: no wheel is built, as this Python has no {' and no '.join(missing)}")
        sys.exit(77)
    unittest.main(argv=sys.argv[:1], verbosity=2)
