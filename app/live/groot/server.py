"""Groot2 server: the monitor protocol of BehaviorTree.CPP 4, version 2, little-endian.

A request is a header of 6 bytes (protocol, kind, number) and for some kinds a second part. A reply
repeats the header, adds 16 bytes that identify the tree, and may have a second part. An invalid
request is answered by `error` and the reason.
"""

from __future__ import annotations

import queue
import secrets
import struct
import threading
from collections.abc import Callable, Mapping, Sequence
from types import ModuleType
from typing import Any

from py_trees.common import Status

from app.live.groot.client_hooks import ClientHooks
from app.live.nodes import NodeInfo
from app.live.operator import Control, Hook
from app.live.snapshot import Snapshot
from config import UserError, extra
from hw import begun, stopwatch
from trees.btcpp import STATUS_CODES, tree_xml

HOST = "127.0.0.1"
USUAL_PORT = 1667  # Groot2's default; breakpoints are announced on the next port

_HEADER_SIZE = 6
_STATUS = struct.Struct("<HB")
_IDLE_AFTER = 10
_HEARTBEAT = 5.0  # silence after which the breakpoints of a client are disabled [s of real time]
_POLL_MS = 20
_MOST_BYTES = 1_000_000  # of a request; a client that sends more is disconnected
_MOST_WAITING = 100  # requests that wait for an answer


class GrootError(UserError):
    """The endpoint cannot be served as requested."""


class GrootServer:
    """Serves one run on its own thread until the end of the `with` statement.

    A breakpoint pauses the whole run. When the client falls silent its breakpoints are disabled,
    but a paused robot stays paused until a person resumes.

    `tree` has the nodes in preorder and `hooks` one for each of them. Requests come to `port`, and
    breakpoints are announced on the next one. `seconds` is real time, for the heartbeat [s]. Raises
    GrootError: a port is taken, or the extra is not installed.
    """

    def __init__(
        self,
        task: str,
        tree: Sequence[NodeInfo],
        hooks: Sequence[Hook],
        control: Control,
        *,
        port: int = USUAL_PORT,
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self._zmq, self._pack = _libraries()
        self._task = task
        self._uids = {hook: uid for uid, hook in enumerate(hooks, start=1)}
        self._client_hooks = client = ClientHooks(hooks, control)
        self._seconds = seconds
        self._tree_id = secrets.token_bytes(16)
        self._lock = threading.Lock()
        self._codes = [0] * len(tree)
        self._values: Mapping[str, object] = {}
        self._notices: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._heard = seconds()
        self._over = threading.Event()
        xml = tree_xml(task, [(node.name, node.kind, node.depth) for node in tree]).encode()
        self._answers: dict[bytes, Callable[[bytes], bytes | None]] = {
            b"T": lambda _: xml,
            b"S": self._status,
            b"B": self._blackboard,
            b"I": client.insert,
            b"R": client.remove,
            b"U": client.unlock,
            b"D": lambda _: client.dump(),
            b"A": lambda _: client.remove_all(),
            b"X": lambda _: client.disable(),
        }
        self._context = self._zmq.Context()
        # Not REP: a peer that breaks off in a malformed request costs the next one its answer.
        self._requests = self._listen(self._zmq.ROUTER, port)
        self._publisher = self._listen(self._zmq.PUB, port + 1)
        self._thread = begun(self._serve, "groot2")

    def __enter__(self) -> GrootServer:
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        self._context.destroy(linger=0)

    def show(self, snapshot: Snapshot, values: Mapping[str, object]) -> None:
        """Set the tick that clients see, and the values of their blackboard; from the loop."""
        with self._lock:
            self._values = values
            self._codes = [
                _code(node.status, before)
                for node, before in zip(snapshot.nodes, self._codes, strict=True)
            ]

    def reached(self, hook: Hook) -> None:
        """Announce that the run pauses before a node; from the loop."""
        self._notices.put(self._uids[hook])

    def _listen(self, kind: int, port: int) -> Any:
        socket = self._context.socket(kind)
        socket.setsockopt(self._zmq.LINGER, 0)
        socket.setsockopt(self._zmq.MAXMSGSIZE, _MOST_BYTES)
        socket.setsockopt(self._zmq.RCVHWM, _MOST_WAITING)
        try:
            socket.bind(f"tcp://{HOST}:{port}")
        except self._zmq.ZMQError as error:
            self._context.destroy(linger=0)
            raise GrootError(
                f"--groot2: port {port} on {HOST}: {error.strerror}; choose another --groot2-port"
            ) from error
        return socket

    def _serve(self) -> None:
        while not self._over.is_set():
            while not self._notices.empty():
                uid = str(self._notices.get()).encode()
                self._publisher.send_multipart([b"\x02N" + secrets.token_bytes(4), uid])
            if self._requests.poll(_POLL_MS):
                self._heard = self._seconds()
                self._client_hooks.set_silent(False)
                envelope, request = _opened(self._requests.recv_multipart())
                if envelope:
                    self._requests.send_multipart([*envelope, *self._answer(request)])
            elif self._seconds() - self._heard > _HEARTBEAT:
                self._client_hooks.set_silent(True)

    def _answer(self, request: list[bytes]) -> list[bytes]:
        """The parts of a reply; errors have the words of BehaviorTree.CPP."""
        try:
            header = request[0]
            if len(header) != _HEADER_SIZE:
                raise ValueError("wrong request header")
            answer = self._answers.get(header[1:2])
            if answer is None:
                raise ValueError("Request not recognized")
            body = answer(request[1] if len(request) > 1 else b"")
        except Exception as error:  # whatever a client sends, the next one gets its answer
            return [b"error", str(error).encode("ascii", errors="backslashreplace")]
        first = header + self._tree_id
        return [first] if body is None else [first, body]

    def _status(self, _: bytes) -> bytes:
        """3 bytes per node: number from 1 in preorder, status."""
        with self._lock:
            return b"".join(_STATUS.pack(uid, code) for uid, code in enumerate(self._codes, 1))

    def _blackboard(self, names: bytes) -> bytes:
        with self._lock:
            boards = {self._task: self._values}
        if wanted := names.decode():  # without a name, every board
            boards = {name: boards[name] for name in wanted.split(";") if name in boards}
        packed: bytes = self._pack(boards, default=str)
        return packed


def _code(status: Status, before: int) -> int:
    """A status as a byte; that of an idle node includes its previous status."""
    if status is not Status.INVALID:
        return STATUS_CODES[status]
    return before if before >= _IDLE_AFTER or before == 0 else _IDLE_AFTER + before


def _opened(parts: list[bytes]) -> tuple[list[bytes], list[bytes]]:
    """Envelope, up to the empty part that ends it, and request; no envelope without that part."""
    end = parts.index(b"") + 1 if b"" in parts else 0
    return parts[:end], parts[end:]


def _libraries() -> tuple[ModuleType, Callable[..., bytes]]:
    try:
        import msgpack
        import zmq
    except ImportError as error:
        raise GrootError(f"--groot2 needs {error.name}: {extra('groot')}") from error
    return zmq, msgpack.packb
