"""The sockets of the Groot2 endpoint, and what each request does."""

from __future__ import annotations

import json
import queue
import secrets
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from datetime import UTC, datetime
from types import ModuleType
from typing import Any, NamedTuple

from py_trees.common import Status

from app.control import Act, Control, Hook, Side
from app.groot.document import document
from app.groot.protocol import (
    Header,
    Kind,
    Transition,
    code,
    pack_statuses,
    pack_transitions,
    read_header,
)
from app.monitor import NodeInfo, Snapshot
from hw import stopwatch

HOST = "127.0.0.1"
USUAL_PORT = 1667
"""Where Groot2 looks; notices of breakpoints are published on the next one."""

_HEARTBEAT = 5.0
"""Hooks of a client that has asked nothing for so long are disabled [s of real time]."""
_POLL_MS = 20
_MOST_TRANSITIONS = 1000
_PAUSE, _REPLACE = 0, 1
_OUTCOMES = {"SUCCESS": Status.SUCCESS, "FAILURE": Status.FAILURE}

Reply = bytes | None
"""The second part of a reply, if it has one."""


class GrootError(Exception):
    """The endpoint cannot be had as it was asked for."""


class _Wish(NamedTuple):
    """A hook as the client described it."""

    enabled: bool
    mode: int
    once: bool
    desired_status: str


class GrootServer:
    """Serves one run, from a thread of its own, until the end of the `with` statement.

    A breakpoint pauses the whole run, as the other ways of pausing do. When the client falls
    silent its hooks are disabled, but a robot that is paused stays so until a person says more.

    Args:
        task: name of the task.
        tree: the nodes of the tree, in preorder.
        hooks: one a node.
        control: pauses the run and lets it go on.
        port: for requests; notices go to the next one.
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
        seconds: Callable[[], float] = stopwatch,
    ) -> None:
        self._zmq, self._pack = _libraries()
        self._task = task
        self._document = document(task, tree)
        self._hooks = {uid: hook for uid, hook in enumerate(hooks, start=1)}
        self._standing = {uid: dict(hook.acts) for uid, hook in self._hooks.items()}
        self._uids = {hook: uid for uid, hook in self._hooks.items()}
        self._control = control
        self._seconds = seconds
        self._tree_id = secrets.token_bytes(16)
        self._wishes: dict[tuple[int, Side], _Wish] = {}
        self._lock = threading.Lock()
        self._codes = [0] * len(tree)
        self._values: Mapping[str, object] = {}
        self._stamp = 0.0
        self._recording_since: float | None = None
        self._transitions: deque[Transition] = deque(maxlen=_MOST_TRANSITIONS)
        self._notices: queue.SimpleQueue[tuple[int, Side]] = queue.SimpleQueue()
        self._heard = seconds()
        self._silent = False
        self._over = threading.Event()
        self._answers: dict[Kind, Callable[[bytes], Reply]] = {
            Kind.TREE: lambda _: self._document.encode(),
            Kind.STATUS: self._status,
            Kind.BLACKBOARD: self._blackboard,
            Kind.HOOK_INSERT: self._insert,
            Kind.HOOK_REMOVE: self._remove,
            Kind.HOOK_UNLOCK: self._unlock,
            Kind.HOOKS_DUMP: self._dump,
            Kind.HOOKS_REMOVE_ALL: self._remove_all,
            Kind.HOOKS_DISABLE: self._disable,
            Kind.RECORD: self._record,
            Kind.TRANSITIONS: self._take_transitions,
        }
        self._context = self._zmq.Context()
        self._requests = self._listen(self._zmq.REP, port)
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

    def show(self, seen: Snapshot, values: Mapping[str, object]) -> None:
        """Tell what a tick looked like.

        Args:
            seen: the tick.
            values: what the client is shown as the blackboard.
        """
        with self._lock:
            self._stamp, self._values = seen.stamp, values
            for index, node in enumerate(seen.nodes):
                before, now = self._codes[index], code(node.status, self._codes[index])
                if now == before:
                    continue
                self._codes[index] = now
                if self._recording_since is not None:
                    since = round(1e6 * (seen.stamp - self._recording_since))
                    self._transitions.append(Transition(since, index + 1, code(node.status)))

    def reached(self, hook: Hook, side: Side) -> None:
        """Tell that a hook acts."""
        self._notices.put((self._uids[hook], side))

    # from the thread

    def _listen(self, kind: int, port: int) -> Any:
        socket = self._context.socket(kind)
        socket.setsockopt(self._zmq.LINGER, 0)
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
                self._set_silent(False)
                self._requests.send_multipart(self._answer(self._requests.recv_multipart()))
            elif self._seconds() - self._heard > _HEARTBEAT:
                self._set_silent(True)

    def _notify(self, uid: int, side: Side) -> None:
        """Publish that a hook acts; one that replaces only once is done with it."""
        header = Header(Kind.HOOK_REACHED, secrets.randbits(32))
        self._publisher.send_multipart([header.pack(), str(uid).encode()])
        wish = self._wishes.get((uid, side))
        if wish is not None and wish.once and wish.mode == _REPLACE:
            del self._wishes[uid, side]

    def _set_silent(self, silent: bool) -> None:
        if silent != self._silent:
            self._silent = silent
            for uid in self._hooks:
                self._apply(uid)

    def _answer(self, request: list[bytes]) -> list[bytes]:
        try:
            header = read_header(request[0])
            if header.kind not in self._answers:
                raise ValueError("Request not recognized")
            body = self._answers[header.kind](request[1] if len(request) > 1 else b"")
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            return [b"error", str(error).encode()]
        first = header.pack() + self._tree_id
        return [first] if body is None else [first, body]

    def _status(self, _: bytes) -> Reply:
        with self._lock:
            return pack_statuses(self._codes)

    def _blackboard(self, names: bytes) -> Reply:
        with self._lock:
            boards = {self._task: dict(self._values)}
        if wanted := names.decode():  # no name at all means every board
            boards = {name: boards[name] for name in wanted.split(";") if name in boards}
        packed: bytes = self._pack(boards, default=str)
        return packed

    def _insert(self, text: bytes) -> Reply:
        described = json.loads(text)
        for one in described if isinstance(described, list) else [described]:
            uid, side = self._place(one)
            self._wishes[uid, side] = _Wish(
                enabled=bool(one["enabled"]),
                mode=int(one["mode"]),
                once=bool(one["once"]),
                desired_status=str(one["desired_status"]),
            )
            self._apply(uid)
        return None

    def _remove(self, text: bytes) -> Reply:
        uid, side = self._known(json.loads(text))
        del self._wishes[uid, side]
        self._apply(uid)
        self._let_go(uid)
        return None

    def _unlock(self, text: bytes) -> Reply:
        described = json.loads(text)
        uid, side = self._known(described)
        if described["remove_when_done"] or self._wishes[uid, side].once:
            del self._wishes[uid, side]
            self._apply(uid)
        self._let_go(uid, _OUTCOMES.get(str(described["desired_status"])))
        return None

    def _dump(self, _: bytes) -> Reply:
        return json.dumps(
            [
                {"uid": uid, "position": side.value, **wish._asdict()}
                for (uid, side), wish in self._wishes.items()
            ]
        ).encode()

    def _remove_all(self, _: bytes) -> Reply:
        self._wishes.clear()
        self._apply_all()
        return None

    def _disable(self, _: bytes) -> Reply:
        self._wishes = {at: wish._replace(enabled=False) for at, wish in self._wishes.items()}
        self._apply_all()
        return None

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

    # hooks

    def _place(self, described: dict[str, Any]) -> tuple[int, Side]:
        uid, side = int(described["uid"]), Side(int(described["position"]))
        if uid not in self._hooks:
            raise ValueError("Node ID not found")
        return uid, side

    def _known(self, described: dict[str, Any]) -> tuple[int, Side]:
        place = self._place(described)
        if place not in self._wishes:
            raise ValueError("Node ID not found")
        return place

    def _apply(self, uid: int) -> None:
        """Make a hook do what the client wishes, besides what it did before there was one."""
        acts = dict(self._standing[uid])
        for side in Side:
            wish = self._wishes.get((uid, side))
            if wish is None or not wish.enabled or self._silent:
                continue
            instead = _OUTCOMES.get(wish.desired_status) if wish.mode == _REPLACE else None
            if instead is not None or wish.mode == _PAUSE:
                acts[side] = Act(instead=instead, once=wish.once)
        self._hooks[uid].acts = acts

    def _apply_all(self) -> None:
        for uid in self._hooks:
            self._apply(uid)
            self._let_go(uid)

    def _let_go(self, uid: int, answer: Status | None = None) -> None:
        """Go on if the run waits at a node."""
        hook = self._hooks[uid]
        if hook.waiting:
            hook.answer = answer
            self._control.resume()


def _libraries() -> tuple[ModuleType, Callable[..., bytes]]:
    try:
        import msgpack
        import zmq
    except ImportError as error:
        raise GrootError(
            f'--groot2 needs {error.name}: pip install "frankie-task[groot]"'
        ) from error
    return zmq, msgpack.packb
