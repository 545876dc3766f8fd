# SPDX-License-Identifier: Apache-2.0
"""A client of Galaxy's multiserver in the standard library and NumPy, written from docs/protocol.md. The file may be copied alone.

    from gxy.client import Client, write_png
    with Client(port=5001) as client:
        client.request("load data")
        print(client.request("list")["datasets"])
        window = client.window(1, size=(640, 480))
        window.set(json.load(open("scene.json")))
        picture = window.render(rays=1, passes=4)
        write_png("picture.png", picture.rgba)

gxy.connect() has more comfort: data, graphs and views as objects. Pixels travel as zlib: Python's standard library has
neither zstd nor JPEG.
"""
from __future__ import annotations

import concurrent.futures
import fcntl
import ipaddress
import json
import logging
import os
import re
import socket
import struct
import threading
import time
import zlib
from concurrent.futures import Future
from typing import Any, Callable, Optional

try:
    import numpy as np
except ImportError as e:
    raise ImportError(f"gxy.client: {e}; pictures and arrays of datasets need NumPy: expected it, as Debian's package python3-numpy or "
                      "pip install numpy has it") from e

VERSION = 1
_PREAMBLE = struct.Struct("<8sII")
_HEADER = struct.Struct("<QHHI")
_RECORD = struct.Struct("<IIQ8IHHIQ")
_MAGIC = b"GALAXY\r\n"
_CONTROL, _REQUEST, _REPLY, _EVENT, _PIXELS, _FILE = range(6)
_TILE, _END_OF_PASS, _END_OF_FRAME = 1, 2, 3
_ZLIB = 3
_LONGEST = 1 << 30  # bytes of a payload from the server
_PLACE = re.compile(r'(?P<section>Datasets|Operators|Visualizations|Outputs)\[(?P<name>"(?:[^"\\]|\\.)*")\](?:: `(?P<key>[^`]+)`)?')
_log = logging.getLogger("galaxy")


class GalaxyError(Exception):
    """What the server answered after `error:`, why its answer means nothing, or why the connection ended.

    rank  of the server, if the error is one rank's; else None
    node  the name of the dataset, operator, view or output of a graph that is meant; else None
    path  where in the document, a list of keys, names and indices such as ["Datasets", "seeds", "count"]; else None
    """

    rank: Optional[int] = None
    node: Optional[str] = None
    path: Optional[list[Any]] = None

    def __init__(self, text: str, node: Optional[str] = None, path: Optional[list[Any]] = None, rank: Optional[int] = None) -> None:
        super().__init__(text)
        if node is not None:
            self.node, self.path, self.rank = node, path, rank
            return
        if of_rank := re.match(r"rank (\d+): ", text):
            self.rank = int(of_rank[1])
        if place := _PLACE.search(text):
            self.node = json.loads(place["name"])
            self.path = [place["section"], self.node]
            for part in re.finditer(r"([^.\[\]]+)|\[(\d+)\]", place["key"] or ""):
                self.path.append(part[1] if part[2] is None else int(part[2]))


class Timeout(GalaxyError, TimeoutError):
    """What was waited for has not come in time."""


def split_address(text: str) -> tuple[str, int]:
    """Host and port of "HOST:PORT", "HOST" (port 5001) or "[IPV6]:PORT"."""
    match = re.fullmatch(r"(\[[0-9A-Fa-f:.]+\]|[^:\s]+)(?::(\d{1,5}))?", text)
    if not match or not 0 < int(match[2] or 5001) < 65536:
        raise GalaxyError(f"address {text!r}, expected HOST:PORT")
    return match[1].strip("[]"), int(match[2] or 5001)


def token_file(port: int, tenant: Optional[str] = None) -> str:
    """Where a server on this machine leaves its token; that of the administrator unless a tenant is named."""
    folder = os.environ.get("XDG_RUNTIME_DIR")
    folder = os.path.join(folder, "galaxy") if folder else f"/tmp/galaxy-{os.getuid()}"
    return os.path.join(folder, f"{port}.{tenant}.token" if tenant else f"{port}.token")


def read_token(path: str, of_server: bool = False) -> str:
    """The token in a file. With of_server, GalaxyError where the server that left it was killed: it keeps its file locked."""
    try:
        with open(path, encoding="ascii") as file:
            if of_server and _unlocked(file):
                raise GalaxyError(f"{path}: a server that was killed has left this token, and none runs on that port now")
            return file.readline().strip()
    except OSError as e:
        raise GalaxyError(f"{path}: {e.strerror}; is a server running on that port, started by you? For one "
                          "elsewhere, copy its token file and name it") from e


def _unlocked(file):
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:  # locked, or on a file system without locks
        return False
    return True


def _token_for(host, port):
    """(the token of a server on this machine, why there is none). An ssh tunnel ends here, too.

    No other machine is sent a token by itself. Where there is none the server may still be one that asks for none.
    """
    try:
        addresses = {entry[4][0] for entry in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)}
    except OSError as e:
        raise GalaxyError(f"cannot connect to {host} port {port}: {e}") from e
    for address in addresses:
        if not ipaddress.ip_address(address).is_loopback:
            raise GalaxyError(f"host {host} is another machine ({address}), and everything goes there as clear text, the "
                              "token, too: expected an ssh tunnel, or the file of a copy of the server's token")
    try:
        return read_token(token_file(port), of_server=True), None
    except GalaxyError as e:
        return "", str(e)


class Picture:
    """One frame of a window.

    rgba     uint8 (height, width, 4), row 0 at the bottom, not premultiplied; None if no tile of level 1 came
    levels   the same for each level that came, by its scale; rgba is levels[1]
    frame    its number
    end      the object of its last record: status, generations, seconds, passes, or error
    foreign  the encoding of tiles that were left out, as they came in another one than zlib; then it has failed
    """

    def __init__(self, frame):
        self.frame = frame
        self.levels = {}
        self.end = {}
        self.foreign = None

    @property
    def rgba(self) -> Optional[np.ndarray]:
        return self.levels.get(1)


class Window:
    """A window of the server, made by Client.window. Its methods may be called from any thread."""

    def __init__(self, client, number):
        self._client = client
        self.number = number
        self._changed = threading.Condition()
        self._picture = None  # the newest frame
        self._ends = {}  # by frame number, the newest 64
        self._failure = None

    def set(self, state: dict[str, Any]) -> dict[str, Any]:
        """What it shows: a state document or a part of one. The reply has `warnings`."""
        return self._client.request(f"viewer.set {self.number} {json.dumps(state)}")

    def start(self, timeout: Optional[float] = None, **options: Any) -> int:
        """Begins a frame, which supersedes older ones; options as in `viewer.render`. Its number, once its scene is ready."""
        options["encoding"] = "zlib"
        return self._client.request(f"viewer.render {self.number} {json.dumps(options)}", timeout)["frame"]

    def wait(self, frame: int, timeout: Optional[float] = 60) -> Picture:
        """Waits until this frame or a later one has ended; the picture of the newest, however it ended."""
        with self._changed:
            if not self._changed.wait_for(
                    lambda: self._failure or any(n >= frame for n in self._ends), timeout):
                raise Timeout(f"window {self.number}: frame {frame} has not ended after {timeout:g} s")
            if not any(n >= frame for n in self._ends):
                raise GalaxyError(self._failure)
            return self._ends[max(self._ends)]

    def render(self, timeout: Optional[float] = 60, **options: Any) -> Picture:
        """Begins a frame and waits for it, or for the newer one that has superseded it, as one of newer data in a window that
        follows. Raises GalaxyError unless it is completed."""
        end = None if timeout is None else time.monotonic() + timeout
        picture = self.wait(self.start(timeout, **options), end and end - time.monotonic())
        while picture.end["status"] == "superseded":
            picture = self.wait(picture.frame + 1, end and end - time.monotonic())
        if picture.end["status"] != "complete":
            raise GalaxyError(f"window {self.number}, frame {picture.frame}: " +
                              picture.end.get("error", picture.end["status"]))
        return picture

    def close(self, timeout: Optional[float] = 10) -> None:
        self._client._windows.pop(self.number, None)
        self._client.request(f"viewer.close {self.number}", timeout)

    def _take(self, record):
        (kind, _, frame, width, height, scale, _, x, y, w, h, encoding, _, _, size) = _RECORD.unpack_from(record)
        data = memoryview(record)[_RECORD.size:]
        if len(data) != size:
            raise GalaxyError(f"pixels: {len(data)} bytes of data, their header says {size}")
        with self._changed:
            # the end of a frame that waited and was overtaken comes while an older one is under way
            if kind == _TILE and (self._picture is None or frame > self._picture.frame):
                self._picture = Picture(frame)
            picture = self._picture
            if kind == _TILE and frame == picture.frame:
                if encoding != _ZLIB:  # asked for by a request that was not start()'s
                    picture.foreign = encoding
                    return
                if x + w > width or y + h > height:
                    raise GalaxyError(f"pixels: a tile of {w} x {h}, expected one inside {width} x {height}")
                data = zlib.decompressobj().decompress(data, w * h * 4)
                if len(data) != w * h * 4:
                    raise GalaxyError(f"pixels: a tile of {len(data)} bytes, expected {w} x {h} x 4")
                level = picture.levels.get(scale)
                if level is None:
                    level = picture.levels[scale] = np.zeros((height, width, 4), np.uint8)
                level[y:y + h, x:x + w] = np.frombuffer(data, np.uint8).reshape(h, w, 4)
            elif kind == _END_OF_FRAME:
                ended = picture if picture and frame == picture.frame else Picture(frame)
                ended.end = json.loads(bytes(data))
                if ended.foreign is not None:
                    ended.end = {"status": "failed", "error": f"its tiles came in encoding {ended.foreign}, expected zlib, "
                                                              'which a request "render" has to ask for'}
                self._ends[frame] = ended
                while len(self._ends) > 64:
                    del self._ends[min(self._ends)]
                self._changed.notify_all()

    def _fail(self, reason):
        with self._changed:
            self._failure = reason
            self._changed.notify_all()


class _Arrays:
    """The arrays of a fetch, as their parts come."""

    def __init__(self):
        self._arrays = {"structure": {}, "fields": {}}
        self._problem = None  # the first, which of() raises

    def take(self, _, header, content):
        try:
            self._take(header, content)
        except Exception as e:
            self._problem = self._problem or e

    def _take(self, header, content):
        kind, name = ("structure", "structure") if "structure" in header else ("fields", "field")
        values = np.frombuffer(content, np.dtype(header["type"]).newbyteorder("<"))
        n = header["components"]
        array = self._arrays[kind].setdefault(header[name], np.empty(header["of"] * n, values.dtype))
        array[header["first"] * n:(header["first"] + header["count"]) * n] = values
        if header["first"] + header["count"] == header["of"] and n > 1:
            self._arrays[kind][header[name]] = array.reshape(-1, n)

    def of(self, reply):
        if self._problem:
            raise GalaxyError(f"an array of the dataset could not be stored: {self._problem}") from self._problem
        if "dimensions" in reply:
            for name, array in self._arrays["fields"].items():
                self._arrays["fields"][name] = array.reshape(*reversed(reply["dimensions"]), *array.shape[1:])
        return self._arrays


class Client:
    """One connection. A thread of its own reads, answers pings, and calls the callbacks, which must be short. What they
    raise is logged (logger "galaxy") and changes nothing.

    token        text; default: what is in token_file; default: where a server on this machine leaves it, if it does, and an
                 error for other machines
    tenant       for servers that run with --no-token, for which there is token="" (or token_file="-")
    on_end       called with the reason once the connection has ended, also by close()
    timeout      seconds that connecting, and each answer of the handshake, may take
    on_event     called with each event, a dict
    on_file      called with (request id, dict, bytes) for each picture of a batch to the client
    welcome      the server's answer to the handshake, a dict
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 5001, token: Optional[str] = None, token_file: Optional[str] = None,
                 tenant: str = "user", name: str = "gxy", on_event: Optional[Callable[[dict[str, Any]], None]] = None,
                 on_file: Optional[Callable[[int, dict[str, Any], bytes], None]] = None,
                 on_end: Optional[Callable[[str], None]] = None, timeout: Optional[float] = 10) -> None:
        why_none = None
        if token_file == "-":
            token = ""
        elif token is None and token_file:
            token = read_token(token_file)
        elif token is None:
            token, why_none = _token_for(host, port)
        self._on_event, self._on_file, self._on_end = on_event, on_file, on_end
        self._lock = threading.Lock()  # of the five below
        self._replies: dict[int, Future[dict[str, Any]]] = {}
        self._windows: dict[int, Window] = {}
        self._next_id, self._ended = 1, None
        self._on_files: dict[int, Callable[..., None]] = {}  # by request, where its file records go
        self._sending = threading.Lock()
        try:
            self._socket = socket.create_connection((host, port), timeout)
        except OSError as e:
            raise GalaxyError(f"cannot connect to {host} port {port}: {e}; is a server running there?") from e
        try:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._socket.sendall(_PREAMBLE.pack(_MAGIC, VERSION, 0))
            magic, version, _ = _PREAMBLE.unpack(self._read(_PREAMBLE.size))
            if magic != _MAGIC or version != VERSION:
                raise GalaxyError(f"{host} port {port}: expected a multiserver of protocol version {VERSION}, found " +
                                  (f"version {version}" if magic == _MAGIC else "something else"))
            hello = {"token": token, "client": name, "tenant": tenant}
            self._send(_CONTROL, 0, b"hello " + json.dumps(hello).encode())
            _, _, answer = self._read_message()
            word, _, rest = answer.decode().partition(" ")
            if word != "welcome":
                raise GalaxyError(f"{host} port {port}: {rest}" + (f" (none was sent: {why_none})" if why_none else ""))
            self.welcome = json.loads(rest)
            self._socket.settimeout(None)
        except (OSError, GalaxyError) as e:
            self._socket.close()
            raise e if isinstance(e, GalaxyError) else GalaxyError(f"{host} port {port}: {e}") from e
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def __enter__(self) -> Client:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        try:
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass  # it has ended already
        self._thread.join()
        self._socket.close()

    def send(self, statement: str, on_file: Optional[Callable[..., None]] = None) -> tuple[int, Future[dict[str, Any]]]:
        """Sends a statement. (its id, a Future of the reply's object or GalaxyError)

        on_file, if given, is called with the file records of this request in place of the client's on_file.
        """
        payload = statement.encode()
        most = self.welcome.get("limits", {}).get("request bytes", 1 << 24)
        if len(payload) > most:
            raise GalaxyError(f"a request of {len(payload)} bytes, expected at most {most}")
        with self._lock:
            if self._ended:
                raise GalaxyError(f"the connection has ended: {self._ended}")
            number = self._next_id
            reply: Future[dict[str, Any]] = Future()
            self._next_id = number % 0xFFFFFFFF + 1
            self._replies[number] = reply
            if on_file:
                self._on_files[number] = on_file
        try:
            self._send(_REQUEST, number, payload)
        except OSError as e:
            with self._lock:
                self._replies.pop(number, None)
                self._on_files.pop(number, None)
            raise GalaxyError(f"the connection has ended: {self._ended or e}") from e
        return number, reply

    def request(self, statement: str, timeout: Optional[float] = None) -> dict[str, Any]:
        """Sends a statement and waits; the reply's object, {} if it has none. Raises GalaxyError for an error, and Timeout after
        so many seconds, when it has cancelled the request."""
        return self._result(statement, None, timeout)

    def fetch(self, name: str, timeout: Optional[float] = None) -> dict[str, Any]:
        """What a dataset holds: the object of the reply of data.fetch with two members more. Loads module data.

        structure    arrays by name, of geometry: points (float64, N x 3), normals, segments, triangles, ids; of an unstructured volume: points,
                     types, offsets and connectivity of cells, as in VTK
        fields       arrays by name: of a volume (nz, ny, nx) or (nz, ny, nx, components), of points or cells (N,) or (N, components)
        """
        arrays = _Arrays()
        self.request("load data")
        reply = self._result(f"data.fetch {json.dumps(name)}", arrays.take, timeout)
        return reply | arrays.of(reply)

    def window(self, number: int, timeout: Optional[float] = None, **settings: Any) -> Window:
        """Makes window `number`, or changes it: size=(width, height), follow=True. Loads module viewer. Each of the two answers may take
        `timeout` seconds."""
        self.request("load viewer", timeout)
        with self._lock:
            window = self._windows.setdefault(number, Window(self, number))
        self.request(f"viewer.window {number} {json.dumps(settings)}", timeout)
        return window

    def _result(self, statement, on_file, timeout):
        number, reply = self.send(statement, on_file)
        try:
            return reply.result(timeout)
        except concurrent.futures.TimeoutError:
            if reply.done():
                raise  # the request's own
            self.send(f"cancel {number}")
            raise Timeout(f"no answer to `{statement[:80]}` after {timeout:g} s") from None

    def _send(self, channel, number, payload):
        with self._sending:
            self._socket.sendall(_HEADER.pack(len(payload), channel, 0, number) + payload)

    def _read(self, size):
        data = bytearray(size)
        at = 0
        while at < size:
            count = self._socket.recv_into(memoryview(data)[at:])
            if count == 0:
                raise GalaxyError("the server has closed the connection")
            at += count
        return data

    def _read_message(self):
        size, channel, _, number = _HEADER.unpack(self._read(_HEADER.size))
        if size > _LONGEST:
            raise GalaxyError(f"a message of {size} bytes, expected at most {_LONGEST}")
        return channel, number, self._read(size)

    def _run(self):
        try:
            while True:
                channel, number, payload = self._read_message()
                if channel == _CONTROL:
                    word, _, rest = payload.decode().partition(" ")
                    if word == "ping":
                        self._send(_CONTROL, 0, b"pong " + rest.encode())
                    elif word == "bye":
                        raise GalaxyError(rest)
                else:
                    self._take(channel, number, payload)
        except Exception as e:  # whatever it is, those who wait must hear of it
            reason = str(e)
        with self._lock:
            self._ended = reason
            replies, self._replies = self._replies, {}
            windows = list(self._windows.values())
        for reply in replies.values():
            if reply.set_running_or_notify_cancel():
                reply.set_exception(GalaxyError(f"the connection has ended: {reason}"))
        for window in windows:
            window._fail(f"the connection has ended: {reason}")
        if self._on_end:
            self._call(self._on_end, reason)

    def _take(self, channel, number, payload):
        if channel == _REPLY:
            value, failure = _reply_of(payload)
            with self._lock:
                reply = self._replies.pop(number, None)
                self._on_files.pop(number, None)
            if reply is None:
                raise GalaxyError(f"reply to request {number}, which is not out")
            if not reply.set_running_or_notify_cancel():
                return  # whoever asked does not wait any more
            if failure:
                reply.set_exception(failure)
            else:
                reply.set_result(value)
        elif channel == _EVENT:
            if self._on_event:
                self._call(self._on_event, json.loads(payload))
        elif channel == _PIXELS:
            with self._lock:
                window = self._windows.get(struct.unpack_from("<I", payload, 4)[0])
            if window:
                window._take(payload)
        elif channel == _FILE:
            with self._lock:
                on_file = self._on_files.get(number, self._on_file)
            if on_file:
                (size,) = struct.unpack_from("<I", payload)
                self._call(on_file, number, json.loads(payload[4:4 + size]), bytes(payload[4 + size:]))

    @staticmethod
    def _call(callback, *arguments):
        try:
            callback(*arguments)
        except Exception:  # the connection is not to blame
            _log.exception("a callback failed")


def _reply_of(payload):
    """(the reply's object, None), or (None, a GalaxyError): also of a reply that means nothing, so that who waits is told."""
    word, _, rest = payload.decode(errors="replace").partition(" ")
    if word == "error:":
        return None, GalaxyError(rest)
    try:
        value = json.loads(rest) if rest else {}
    except (ValueError, RecursionError) as e:
        return None, GalaxyError(f"reply: {e}")
    if word != "ok" or not isinstance(value, dict):
        return None, GalaxyError("reply: expected `ok`, perhaps with a JSON object, or `error: ...`")
    return value, None


def png(rgba: np.ndarray) -> bytes:
    """A PNG file of uint8 (height, width, 4), row 0 at the bottom."""
    height, width, _ = rgba.shape
    rows = np.zeros((height, 1 + 4 * width), np.uint8)  # each row begins with its filter: none
    rows[:, 1:] = rgba[::-1].reshape(height, 4 * width)

    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b""))


def write_png(path: str, rgba: np.ndarray) -> None:
    """Writes uint8 (height, width, 4), row 0 at the bottom."""
    with open(path, "wb") as file:
        file.write(png(rgba))
