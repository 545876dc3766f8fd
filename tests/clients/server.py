# SPDX-License-Identifier: Apache-2.0
"""A gxyserver for tests: started under MPI with a folder of data, stopped when the test ends."""
import os
import pathlib
import signal
import subprocess
import tempfile
import time

# With the isosurface, and occlusion that passes refine.
STATE = {
    "Datasets": [{"name": "balls", "type": "Volume", "filename": "balls.vti", "array": "oneBall"}],
    "Renderer": {"background": [0.1, 0.2, 0.3, 0.5]},
    "Visualization": {
        "Lighting": {"shadows": True, "ao count": 2, "ao radius": 0.5},
        "operators": [{"type": "Volume", "dataset": "balls", "colormap": "Viridis", "data range": [0, 1.7],
                       "isovalues": [0.5], "volume rendering": True, "extinctionmap": [[0, 0], [0.8, 0.5], [1.7, 2]]}],
    },
    "Camera": {"viewpoint": [3, 2, 4], "viewcenter": [0, 0, 0], "viewup": [0, 1, 0], "aov": 30,
               "dimensions": [300, 260]},
}


class Server:
    """`programs`: the folder of gxyserver and gxydata; `mpiexec`: the command that starts ranks, in words; `options`: more of
    gxyserver's; `seconds`: that it may take to start; `wrapper`: a command that starts the server on each rank."""

    def __init__(self, programs, mpiexec, ranks=2, options=(), seconds=60, wrapper=()):
        self._temporary = tempfile.TemporaryDirectory(prefix="galaxy-clients-")
        self.folder = pathlib.Path(self._temporary.name)
        self.token = self.folder / "token"
        self.programs = pathlib.Path(programs).resolve()
        subprocess.run([self.programs / "gxydata", "radial", "-r", "24", "balls.vti"], cwd=self.folder, check=True,
                       stdout=subprocess.DEVNULL)
        port_file = self.folder / "port"
        self._log = open(self.folder / "server.log", "wb")
        self._process = subprocess.Popen(
            [*mpiexec, "-n", str(ranks), *wrapper, self.programs / "gxyserver", "--port", "0", "--port-file", port_file,
             "--token-file", self.token, *options], cwd=self.folder, stdout=self._log, stderr=subprocess.STDOUT,
            env={**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"})
        end = time.monotonic() + seconds
        while not port_file.exists():
            if self._process.poll() is not None or time.monotonic() > end:
                raise RuntimeError("gxyserver does not listen:\n" + self.log())
            time.sleep(0.05)
        self.port = int(port_file.read_text())

    @property
    def process(self):
        """The number of the process that starts the ranks."""
        return self._process.pid

    def terminate(self):
        self._process.terminate()

    def log(self):
        return (self.folder / "server.log").read_text()

    def stop(self, seconds=5):
        """Its exit status: 0 after `quit`, after which it may take so long to end."""
        try:
            status = self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            self._process.send_signal(signal.SIGTERM)
            status = self._process.wait(30)
        self._log.close()
        self._temporary.cleanup()
        return status
