# SPDX-License-Identifier: Apache-2.0
"""A slow link, simulated: a TCP proxy that lets so many bits a second through each way, and each so much later.

    link.py PORT [--rate 20e6] [--delay 0.02]     before 127.0.0.1:PORT; prints the port that it listens on

Bytes are taken from the sender at the link's rate, not sooner (a full link pushes back through a small socket buffer, as a
router's queue does), and are given to the receiver `delay` seconds after they were taken. `delay` is one way: a round trip
takes twice as long.
"""
import argparse
import collections
import socket
import threading
import time

_CHUNK = 1500  # bytes: a packet
_QUEUE = 64 << 10  # bytes that wait before the link, in the system


class Link:
    """Listens on `port` (of 127.0.0.1) until stop(). `bytes`: that have come through from the server."""

    def __init__(self, server_port, bits_per_second, delay):
        self._server, self._rate, self._delay = server_port, bits_per_second / 8, delay
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.bytes = 0
        self._sockets = [self._listener]
        threading.Thread(target=self._accept, daemon=True).start()

    def stop(self):
        for s in self._sockets:
            try:
                s.shutdown(socket.SHUT_RDWR)
            except OSError:
                pass  # it has ended already
            s.close()

    def _accept(self):
        while True:
            try:
                client, _ = self._listener.accept()
            except OSError:
                return
            server = socket.socket()
            for s in (client, server):
                s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _QUEUE // 2)  # the system doubles it
                s.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            server.connect(("127.0.0.1", self._server))
            self._sockets += [client, server]
            self._carry(client, server, False)
            self._carry(server, client, True)

    def _carry(self, source, sink, counted):
        travelling = collections.deque()  # (when it arrives, bytes), b"" at the end
        ready = threading.Semaphore(0)

        def take():
            free = time.monotonic()  # when the link has sent what it took
            data = True
            while data:
                try:
                    data = source.recv(_CHUNK)
                except OSError:
                    data = b""
                now = time.monotonic()
                free = max(free, now) + len(data) / self._rate
                if counted:
                    self.bytes += len(data)
                travelling.append((free + self._delay, data))
                ready.release()
                if free - now > 0.002:  # sleeps are coarse
                    time.sleep(free - now)

        def give():
            while True:
                ready.acquire()
                at, data = travelling.popleft()
                time.sleep(max(0, at - time.monotonic()))
                try:
                    if not data:
                        sink.shutdown(socket.SHUT_WR)
                        return
                    sink.sendall(data)
                except OSError:
                    return

        for work in (take, give):
            threading.Thread(target=work, daemon=True).start()


def main():
    parser = argparse.ArgumentParser(description="A slow link before a port of this machine.")
    parser.add_argument("port", type=int)
    parser.add_argument("--rate", type=float, default=20e6, help="bits a second, each way (default 20e6)")
    parser.add_argument("--delay", type=float, default=0.02, help="seconds, one way (default 0.02)")
    arguments = parser.parse_args()
    print(Link(arguments.port, arguments.rate, arguments.delay).port, flush=True)
    threading.Event().wait()


if __name__ == "__main__":
    main()
