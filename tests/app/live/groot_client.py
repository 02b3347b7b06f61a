"""A Groot2 client that speaks the protocol byte for byte, and a tree that is served to it."""

import json
import os
import socket
import struct

import pytest
from py_trees.common import Status
from sample_run import TREE

from app.live.groot import GrootServer
from app.live.operator import Control, Hook
from trees.words.branch import Branch

zmq = pytest.importorskip("zmq", reason='needs pip install "frankie-task[groot]"')


def free_pair() -> int:
    """A free port whose neighbour is free too.

    It is below the ports that the system gives to whoever asks for any (from 32768 on), so that
    nobody gets it by chance before it is used; and every process begins to look elsewhere.
    """
    for port in range(20_000 + 2 * (os.getpid() % 6_000), 32_766, 2):
        with socket.socket() as first, socket.socket() as second:
            try:
                first.bind(("127.0.0.1", port))
                second.bind(("127.0.0.1", port + 1))
            except OSError:
                continue
            return port
    raise AssertionError("no two free ports beside each other")


PORT = free_pair()


class Nothing(Branch):
    """Stands for a node of the sample run; only its name matters here."""

    key = "nothing"

    def advance(self):
        yield from ()
        return Status.SUCCESS


class Client:
    """Sends requests as Groot2 does, and checks the head of every reply."""

    def __init__(self, context) -> None:
        self.socket = self._connected(context, zmq.REQ, PORT)
        self.notices = self._connected(context, zmq.SUB, PORT + 1)
        self.notices.setsockopt(zmq.SUBSCRIBE, b"")
        self.number = 0x01020304

    def _connected(self, context, kind: int, port: int):
        made = context.socket(kind)
        made.setsockopt(zmq.RCVTIMEO, 60_000)
        made.connect(f"tcp://127.0.0.1:{port}")
        return made

    def ask(self, letter: bytes, body: bytes | None = None) -> list[bytes]:
        self.number += 1
        head = b"\x02" + letter + struct.pack("<I", self.number)
        self.socket.send_multipart([head] if body is None else [head, body])
        reply = self.socket.recv_multipart()
        if reply[0] != b"error":
            assert reply[0][:6] == head
            assert len(reply[0]) == 22
        return reply

    def hook(self, uid: int, **more: object) -> list[bytes]:
        described = {"enabled": True, "uid": uid, "mode": 0, "once": False, "position": 0}
        described |= {"desired_status": "SKIPPED"} | more
        return self.ask(b"I", json.dumps(described).encode())

    def unlock(self, uid: int, status: str = "SKIPPED", remove: bool = False) -> list[bytes]:
        described = {"uid": uid, "desired_status": status, "position": 0}
        return self.ask(b"U", json.dumps(described | {"remove_when_done": remove}).encode())


class ServedTree:
    """A served tree, its hooks, and the clock of the heartbeat."""

    def __init__(self) -> None:
        self.control = Control()
        self.now = 0.0
        self.hooks = [Hook(Nothing(node.name, []), self._reached) for node in TREE]
        self.server = GrootServer(
            "demo", TREE, self.hooks, self.control, port=PORT, seconds=lambda: self.now
        )

    def _reached(self, hook: Hook) -> None:
        self.control.pause(f"before {hook.name}")
        self.server.reached(hook)

    def tick(self, uid: int) -> Status:
        self.hooks[uid - 1].tick_once()
        return self.hooks[uid - 1].status
