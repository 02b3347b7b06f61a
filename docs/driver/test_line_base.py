"""The driver keeps the contract, on a simulated base."""

import socketserver
import threading
import time
from contextlib import contextmanager
from math import cos, sin

from line_base import LineBase, Options

from frankie_task.testing import check_driver


class Base(socketserver.StreamRequestHandler):
    """One connection to a base that does what it is told at once; `cut` is a pulled cable."""

    cut = False

    def handle(self):
        self.v = self.w = x = y = heading = 0.0
        threading.Thread(target=self.hear, daemon=True).start()
        while True:
            time.sleep(0.02)
            heading += 0.02 * self.w
            x, y = x + 0.02 * self.v * cos(heading), y + 0.02 * self.v * sin(heading)
            if not Base.cut:
                try:
                    self.wfile.write(f"{x} {y} {heading} {self.v} {self.w}\n".encode())
                except OSError:
                    return

    def hear(self):
        for line in self.rfile:
            self.v, self.w = map(float, line.split())


@contextmanager
def cable_pulled():
    Base.cut = True
    yield
    Base.cut = False


def test_the_driver_keeps_the_contract():
    with socketserver.ThreadingTCPServer(("127.0.0.1", 0), Base) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, daemon=True).start()
        options = Options(address="127.0.0.1", port=server.server_address[1])
        check_driver("base", lambda context: LineBase(options, context), fault=cable_pulled)
        server.shutdown()
