#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Follows a simulation that publishes its steps to a Galaxy server, and leaves pictures of some of them.

    simsim begin.vti end.vti -d 0.5 -n 60 --save steps &
    PYTHONPATH=.../python/src python3 follow.py scene.json -n 3 -o follow
    PYTHONPATH=.../python/src python3 follow.py scene.json --import steps/simsim-7.vti -o import

The first call of follow.py waits for the datasets that the state file shows, such as simsim.oneBall. It then makes a
window that follows them: the server renders it again whenever the simulation has published a step. The pictures of three
steps become follow-STEP.png. The second call shows a file in the same way, and leaves import-simsim-7.png, which is equal
to follow-7.png to the bit. The package gxy does the rest; it needs NumPy.
"""
import argparse
import copy
import json
import pathlib
import sys
import threading

try:
    import gxy.client
except ImportError as e:
    sys.exit(f"follow.py: error: {e}; expected the package gxy of Galaxy in a folder of PYTHONPATH, and NumPy")


class Steps:
    """Which step of the simulation each generation of a dataset shows."""

    def __init__(self):
        self._changed = threading.Condition()
        self._steps = {}  # by name and generation

    def hear(self, event):
        """Takes an event of the server. That of a new generation has its step."""
        if event.get("event") in ("added", "updated") and "step" in event:
            self._learn(event["name"], event["generation"], event["step"])

    def ask(self, client, name):
        """Asks the server which step a dataset shows now."""
        for dataset in client.request(f"data.info {json.dumps(name)}")["datasets"]:
            origins = dataset.get("origins", [])
            if len(origins) == 1:
                self._learn(name, dataset["generation"], origins[0]["step"])

    def of(self, client, generations, seconds=5):
        """The step that a picture shows, by the generations of its datasets: all must be of the same."""
        found = {key[0]: self._of_one(client, key, seconds) for key in generations.items()}
        if len(set(found.values())) != 1:
            raise gxy.client.GalaxyError(f"a picture shows several steps at once: {found}")
        return next(iter(found.values()))

    def _learn(self, name, generation, step):
        with self._changed:
            self._steps[name, generation] = step
            self._changed.notify_all()

    def _of_one(self, client, key, seconds):
        with self._changed:
            # events travel on a channel of their own, so that this one may come after the picture
            if self._changed.wait_for(lambda: key in self._steps, seconds):
                return self._steps[key]
        self.ask(client, key[0])  # the event is lost
        with self._changed:
            if key in self._steps:
                return self._steps[key]
        raise gxy.client.GalaxyError(f"which step is generation {key[1]} of {key[0]}? The server tells it no more")


def shown(state):
    """The operators of a state document's first visualization."""
    visualization = state.get("Visualization", state.get("Visualizations"))
    if isinstance(visualization, list):
        visualization = visualization[0]
    return visualization["operators"]


def size_of(state):
    """The size of the pictures that a state document's first camera makes."""
    camera = state.get("Camera", state.get("Cameras", {}))
    if isinstance(camera, list):
        camera = camera[0]
    return camera.get("dimensions", [512, 512])


def read_state(path):
    """A state document that has what the functions above look for."""
    with open(path, encoding="utf-8") as file:
        state = json.load(file)
    try:
        names = [operator["dataset"] for operator in shown(state)]
        size_of(state)
    except (KeyError, TypeError, IndexError, AttributeError):
        names = []
    if not names:
        raise gxy.client.GalaxyError(f"{path}: expected a state document with a visualization whose operators name datasets")
    return state


def pictures(window, timeout):
    """Whole pictures of a window that follows its data, as they come; those that newer data overtake are left out."""
    picture = window.render(timeout, levels=[1])
    while True:
        if picture.end["status"] == "complete":
            yield picture
        elif picture.end["status"] != "superseded":
            raise gxy.client.GalaxyError(f"frame {picture.frame}: " + picture.end.get("error", picture.end["status"]))
        picture = window.wait(picture.frame + 1, timeout)


def save(arguments, of, picture):
    path = f"{arguments.o}-{of}.png"
    gxy.client.write_png(path, picture.rgba)
    print(path, flush=True)


def follow(client, steps, state, arguments):
    """Leaves pictures of so many different steps of the simulation."""
    names = sorted({operator["dataset"] for operator in shown(state)})
    for name in names:
        client.request(f"data.observe {json.dumps(name)}")
    for name in names:
        client.request(f"data.wait {json.dumps(name)} 1 {arguments.timeout}")
        steps.ask(client, name)  # what came before it was observed
    window = client.window(1, size=size_of(state), follow=True)
    window.set(state)
    saved = set()
    for picture in pictures(window, arguments.timeout):
        step = steps.of(client, picture.end["generations"])
        if step not in saved:
            save(arguments, step, picture)
            saved.add(step)
        if len(saved) == arguments.n:
            return


def show_file(client, state, file, arguments):
    """Leaves a picture that shows a file's arrays in place of the simulation's."""
    state, datasets, stem = copy.deepcopy(state), {}, pathlib.PurePath(file).stem
    for operator in shown(state):
        array = operator["dataset"].partition(".")[2]
        operator["dataset"] = name = f"{stem}.{array}"
        datasets[name] = {"name": name, "type": "Volume", "filename": file, "array": array}
    client.request("data.import " + json.dumps({"Datasets": list(datasets.values())}))
    window = client.window(1, size=size_of(state))
    window.set(state)
    save(arguments, stem, window.render(arguments.timeout, levels=[1]))


def main():
    parser = argparse.ArgumentParser(description="Pictures of a simulation that publishes its steps to a Galaxy server.")
    parser.add_argument("state", metavar="SCENE.json", help="what to show of the datasets STREAM.ARRAY, and from where: "
                        "its first visualization and camera")
    parser.add_argument("-o", metavar="PREFIX", default="step", help="pictures are PREFIX-STEP.png (default: %(default)s)")
    parser.add_argument("-n", metavar="PICTURES", type=int, default=3, help="number of steps (default: %(default)s)")
    parser.add_argument("--import", metavar="FILE", action="append", default=[], dest="files",
                        help="show a file's arrays instead, as PREFIX-FILE.png; relative to the server's --data folders; "
                        "may be repeated")
    parser.add_argument("--timeout", metavar="SECONDS", type=int, default=60,
                        help="give up if no step comes for so long (default: %(default)s)")
    parser.add_argument("-H", "--host", default="127.0.0.1")
    parser.add_argument("-P", "--port", type=int, default=5001)
    parser.add_argument("--token-file", help="file with the server's token; - for none (default: where a server on this "
                        "machine leaves it)")
    arguments = parser.parse_args()
    steps = Steps()
    try:
        state = read_state(arguments.state)
        with gxy.client.Client(arguments.host, arguments.port, token_file=arguments.token_file, name="follow.py",
                           on_event=steps.hear) as client:
            for module in ["data", "viewer"] if arguments.files else ["insitu", "data", "viewer"]:
                client.request(f"load {module}")
            for file in arguments.files:
                show_file(client, state, file, arguments)
            if not arguments.files:
                follow(client, steps, state, arguments)
    except (gxy.client.GalaxyError, OSError, ValueError) as e:
        print(f"follow.py: error: {e}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
