# SPDX-License-Identifier: Apache-2.0
"""A Python client of a graph, for together.test.ts:

    graph_client.py edit HOST:PORT TOKEN_FILE GRAPH SEED     makes a random edit for each line that it reads
    graph_client.py watch HOST:PORT TOKEN_FILE GRAPH         writes each edit that the server has ordered

It writes a line of JSON when it is ready, for each edit, and, for a line `document`, the document."""
import json
import pathlib
import random
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "python/src"))
import gxy  # noqa: E402

mode, address, token_file, graph_name = sys.argv[1:5]


def connect():
    return gxy.connect(address, token_file, name="gxy of the test")


def write(value):
    print(json.dumps(value), flush=True)


def random_edit(document, numbers, number):
    """Edits that may be applied to the document, as somebody would make them. `number` makes each of them another."""
    seeds = [entry["name"] for entry in document["Datasets"] if entry.get("filter") == "Seeds"]
    name = f"p{number}"
    choice = numbers.randrange(6)
    if not seeds or (choice == 0 and len(seeds) < 30):
        return [{"add": ["Datasets"], "to": {"name": name, "filter": "Seeds", "inputs": {"domain": "ball"}, "count": number}}]
    element = numbers.choice(seeds)
    if choice == 1:
        return [{"remove": ["Datasets", element]}]
    if choice == 2:
        return [{"rename": ["Datasets", element], "to": name}]
    if choice == 3:
        return [{"set": ["GUI", name], "to": [number, 0]}, {"set": ["Datasets", element, "seed"], "to": number}]
    return [{"set": ["Datasets", element, "count"], "to": number}]


def is_connected(session):
    try:
        session.ask("graph.list")
    except gxy.GalaxyError:
        return False
    return True


def edit(seed):
    """Connections may be lost: an edit without a reply is not made again."""
    numbers = random.Random(seed)
    session = connect()
    write("ready")
    for number, line in enumerate(sys.stdin, 1):
        try:
            session = session if is_connected(session) else connect()
            graph = session.graph(graph_name)
            document = graph.document
            if line == "document\n":
                write(document)
                continue
            graph.edit(random_edit(document, numbers, number))
            write("made")
        except gxy.GalaxyError as error:
            write(str(error))


def watch():
    session = connect()
    session.on(write, "graph")
    session.graph(graph_name)
    write("ready")
    sys.stdin.read()


edit(int(sys.argv[5])) if mode == "edit" else watch()
