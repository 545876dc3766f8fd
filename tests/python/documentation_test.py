# SPDX-License-Identifier: Apache-2.0
"""documentation_test.py PROGRAMS MPIEXEC...: the code of docs/python.md runs against a real server and prints what the page says, and the
page's reference is that of the docstrings. `documentation_test.py --reference` prints that reference."""
import doctest
import functools
import inspect
import os
import pathlib
import re
import sys
import subprocess
import unittest
import unittest.mock

SOURCE = pathlib.Path(__file__).resolve().parents[2]
PAGE = (SOURCE / "docs/python.md").read_text(encoding="utf-8")
sys.path[:0] = [str(SOURCE / "python/src")]
import gxy  # noqa: E402

CLASSES = [(gxy.Session, "s"), (gxy.Data, "data"), (gxy.Graph, "g"), (gxy.Node, "node"), (gxy.View, "view"), (gxy.Picture, "picture")]


def first_sentence(documented):
    text = " ".join(inspect.getdoc(documented).split("\n\n")[0].split())
    return re.match(r".*?[.:](?= [A-Z]|$)|.*", text)[0].rstrip(".:")


def line(called, name, member):
    """A row of the table for a method or a property."""
    if isinstance(member, property):
        return f"| `{called}.{name}` | {first_sentence(member.fget)} |"
    signature = inspect.signature(member)
    parameters = [p.replace(annotation=p.empty) for p in list(signature.parameters.values())[0 if called == "gxy" else 1:]]
    text = str(inspect.Signature(parameters)).replace("'", '"')
    return f"| `{called}.{name}{text}` | {first_sentence(member)} |"


def reference():
    """A table for each class: its methods and properties but those that end with _async."""
    parts = ["| | |\n|---|---|\n" + line("gxy", "connect", gxy.connect)]
    for kind, called in CLASSES:
        members = [(name, member) for name, member in vars(kind).items() if not name.startswith("_") and not name.endswith("_async")
                   and (isinstance(member, property) or inspect.isfunction(member)) and (getattr(member, "fget", None) or member).__doc__]
        base = " A view is a node, too." if kind is gxy.View else ""
        parts.append(f"**{kind.__name__}.** {first_sentence(kind)}.{base}\n\n| | |\n|---|---|\n" +
                     "\n".join(line(called, *member) for member in members))
    return "\n\n".join(parts) + "\n"


class Page(unittest.TestCase):
    def test_its_code_prints_what_it_says(self):
        server = Server(PROGRAMS, MPIEXEC, 2)
        here = os.getcwd()
        try:
            os.chdir(server.folder)
            subprocess.run([PROGRAMS / "gxydata", "radial", "-r", "48", "radial.vti"], check=True, stdout=subprocess.DEVNULL)
            # The page connects to a server on port 5001 whose token is found; here it is another.
            connect = functools.partial(gxy.connect, f"localhost:{server.port}", str(server.token))
            client = functools.partial(gxy.client.Client, token_file=str(server.token))
            blocks = re.findall(r"^```python\n(.*?)^```$", PAGE, re.M | re.S)
            self.assertGreater(len(blocks), 8)
            self.assertTrue(all(block.startswith(">>> ") for block in blocks), "code without a prompt would not be run")
            text = "\n".join(blocks).replace("port=5001", f"port={server.port}")
            test = doctest.DocTestParser().get_doctest(text, {}, "docs/python.md", None, 0)
            said = []
            with unittest.mock.patch.object(gxy, "connect", connect), unittest.mock.patch.object(gxy.client, "Client", client):
                results = doctest.DocTestRunner(verbose=False).run(test, out=said.append)
            self.assertEqual(results.failed, 0, "".join(said))
            for file in ("first.png", "graph.json", "scene.json", "step-1.png", "plain.png"):
                self.assertGreater((server.folder / file).stat().st_size, 100, file)
            with connect() as session:
                session.ask("quit")
        finally:
            os.chdir(here)
            status = server.stop()
        self.assertEqual(status, 0)

    def test_its_reference_is_that_of_the_docstrings(self):
        self.assertEqual(PAGE.partition("## Reference\n")[2].partition("tells more.\n\n")[2], reference())


if __name__ == "__main__":
    if sys.argv[1:] == ["--reference"]:
        print(reference(), end="")
        sys.exit()
    sys.path[:0] = [str(SOURCE / "tests/clients")]
    from server import Server
    PROGRAMS, MPIEXEC = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:]
    unittest.main(argv=sys.argv[:1], verbosity=2)
