"""Groot2 server: its sockets, and the answer to each request."""

from __future__ import annotations

import queue
import secrets
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from types import ModuleType
from typing import Any

from app.live.groot.client_hooks import ClientHooks
from app.live.groot.protocol import (
    Header,
    Kind,
    Transition,
    code,
    pack_statuses,
    pack_transitions,
    read_header,
)
from app.live.groot.tree_xml import tree_xml
from app.live.nodes import NodeInfo
from app.live.operator import Control, Hook, Side
from app.live.snapshot import Snapshot
from config import UserError
from hw import stopwatch

HOST = "127.0.0.1"
USUAL_PORT = 1667
"""Groot2's default; breakpoints are announced on the next port."""

_HEARTBEAT = 5.0
"""Silence after which the hooks of a client are disabled [s of real time]."""
_OLD = 1.0
"""Age from which values are reported as too old [s]."""
_POLL_MS = 20
_MOST_TRANSITIONS = 1000
_MOST_BYTES = 1_000_000
"""Of a request; a client that sends more is disconnected."""
_MOST_WAITING = 100
"""Requests that wait for an answer."""
Reply = bytes | None


class GrootError(UserError):
    """The endpoint cannot be served as requested."""


class GrootServer:
    """Serves one run on its own thread until the end of the `with` statement.

    A breakpoint pauses the whole run. When the client falls silent its hooks are disabled, but a
    paused robot stays paused until a person resumes.

    Args:
        task: name of the task.
        tree: nodes of the tree, in preorder.
        hooks: one per node.
        control: pauses and resumes the run.
        port: for requests; breakpoints are announced on the next one.
        may_replace: whether clients may replace the outcomes of nodes.
        seconds: real time from an arbitrary start, for the heartbeat [s].

    Raises:
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
        may_replace: bool = False,
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self._zmq, self._pack = _libraries()
        self._task = task
        self._xml = tree_xml(task, tree)
        self._uids = {hook: uid for uid, hook in enumerate(hooks, start=1)}
        self._client_hooks = ClientHooks(hooks, control, may_replace=may_replace)
        self._seconds = seconds
        self._tree_id = secrets.token_bytes(16)
        self._lock = threading.Lock()
        self._codes = [0] * len(tree)
        self._values: Mapping[str, object] = {}
        self._stamp = 0.0
        self._shown_at: float | None = None
        self._recording_since: float | None = None
        self._transitions: deque[Transition] = deque(maxlen=_MOST_TRANSITIONS)
        self._notices: queue.SimpleQueue[tuple[int, Side]] = queue.SimpleQueue()
        self._heard = seconds()
        self._over = threading.Event()
        self._answers: dict[Kind, Callable[[bytes], Reply]] = {
            Kind.TREE: lambda _: self._xml.encode(),
            Kind.STATUS: self._status,
            Kind.BLACKBOARD: self._blackboard,
            Kind.HOOK_INSERT: self._client_hooks.insert,
            Kind.HOOK_REMOVE: self._client_hooks.remove,
            Kind.HOOK_UNLOCK: self._client_hooks.unlock,
            Kind.HOOKS_DUMP: lambda _: self._client_hooks.dump(),
            Kind.HOOKS_REMOVE_ALL: lambda _: self._client_hooks.remove_all(),
            Kind.HOOKS_DISABLE: lambda _: self._client_hooks.disable(),
            Kind.RECORD: self._record,
            Kind.TRANSITIONS: self._take_transitions,
        }
        self._context = self._zmq.Context()
        # Not REP: a peer that breaks off in a malformed request costs the next one its answer.
        self._requests = self._listen(self._zmq.ROUTER, port)
        self._publisher = self._listen(self._zmq.PUB, port + 1)
        self._thread = threading.Thread(target=self._serve, name="groot2", daemon=True)
        self._thread.start()

    def __enter__(self) -> GrootServer:
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()
        self._context.destroy(linger=0)

    # from the loop

    def show(self, snapshot: Snapshot, values: Mapping[str, object]) -> None:
        """Set the tick that clients see, and the values of their blackboard."""
        with self._lock:
            self._stamp, self._values = snapshot.stamp, values
            self._shown_at = self._seconds()
            for index, node in enumerate(snapshot.nodes):
                before, now = self._codes[index], code(node.status, self._codes[index])
                if now == before:
                    continue
                self._codes[index] = now
                if self._recording_since is not None:
                    since = round(1e6 * (snapshot.stamp - self._recording_since))
                    self._transitions.append(Transition(since, index + 1, code(node.status)))

    def reached(self, hook: Hook, side: Side) -> None:
        """Announce that a hook acts."""
        self._notices.put((self._uids[hook], side))

    # from the thread

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
                self._notify(*self._notices.get())
            if self._requests.poll(_POLL_MS):
                self._heard = self._seconds()
                self._client_hooks.set_silent(False)
                envelope, request = _opened(self._requests.recv_multipart())
                if envelope:
                    self._requests.send_multipart([*envelope, *self._answer(request)])
            elif self._seconds() - self._heard > _HEARTBEAT:
                self._client_hooks.set_silent(True)

    def _notify(self, uid: int, side: Side) -> None:
        header = Header(Kind.HOOK_REACHED, secrets.randbits(32))
        self._publisher.send_multipart([header.pack(), str(uid).encode()])
        self._client_hooks.replaced(uid, side)

    def _answer(self, request: list[bytes]) -> list[bytes]:
        try:
            header = read_header(request[0])
            if header.kind not in self._answers:
                raise ValueError("Request not recognized")
            body = self._answers[header.kind](request[1] if len(request) > 1 else b"")
        except Exception as error:  # whatever a client sends, the next one gets its answer
            return [b"error", str(error).encode("ascii", errors="backslashreplace")]
        first = header.pack() + self._tree_id
        return [first] if body is None else [first, body]

    def _status(self, _: bytes) -> Reply:
        with self._lock:
            return pack_statuses(self._codes)

    def _blackboard(self, names: bytes) -> Reply:
        with self._lock:
            boards = {self._task: {**self._values, **self._frozen()}}
        if wanted := names.decode():  # without a name, every board
            boards = {name: boards[name] for name in wanted.split(";") if name in boards}
        packed: bytes = self._pack(boards, default=str)
        return packed

    def _frozen(self) -> Mapping[str, float]:
        """Age of the values, if it is too high; the protocol has no other field for it."""
        age = 0.0 if self._shown_at is None else self._seconds() - self._shown_at
        return {"frozen for [s]": round(age, 1)} if age > _OLD else {}

    def _record(self, command: bytes) -> Reply:
        with self._lock:
            self._recording_since = self._stamp if command == b"start" else None
            self._transitions.clear()
        now = round(1e6 * datetime.now(UTC).timestamp())
        return str(now).encode() if command == b"start" else None

    def _take_transitions(self, _: bytes) -> Reply:
        with self._lock:
            taken = pack_transitions(self._transitions)
            self._transitions.clear()
        return taken


def _opened(parts: list[bytes]) -> tuple[list[bytes], list[bytes]]:
    """Envelope, up to the empty part that ends it, and request; no envelope without that part."""
    end = parts.index(b"") + 1 if b"" in parts else 0
    return parts[:end], parts[end:]


def _libraries() -> tuple[ModuleType, Callable[..., bytes]]:
    try:
        import msgpack
        import zmq
    except ImportError as error:
        raise GrootError(
            f'--groot2 needs {error.name}: pip install "frankie-task[groot]"'
        ) from error
    return zmq, msgpack.packb
