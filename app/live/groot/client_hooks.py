"""Breakpoints that a Groot2 client sets."""

import json
from collections.abc import Sequence
from typing import Any

from app.live.operator import ACKNOWLEDGED, Control, Hook

_BREAKPOINT, _BEFORE = 0, 0  # mode and position of a hook: the only ones that are served
_OUTCOMES = ("SUCCESS", "FAILURE")


class ClientHooks:
    """Sets the breakpoints of a tree's hooks as the client requests; used by one thread.

    Requests and the list are JSON. An invalid request raises an exception with a text for the
    client, and changes nothing.

    `hooks` has one per node; a node's number is its position, from 1.
    """

    def __init__(self, hooks: Sequence[Hook], control: Control) -> None:
        self._hooks = dict(enumerate(hooks, start=1))
        self._control = control
        self._requests: dict[int, dict[str, bool]] = {}
        self._silent = False

    def insert(self, text: bytes) -> None:
        """Add one breakpoint or several."""
        described = json.loads(text)
        several = described if isinstance(described, list) else [described]
        requests = {}
        for one in several:
            if (one["mode"], one["position"]) != (_BREAKPOINT, _BEFORE):
                raise ValueError("only breakpoints before a node are served")
            uid = _number(one, self._hooks)
            requests[uid] = {word: bool(one[word]) for word in ("enabled", "once")}
        self._requests |= requests
        self._apply()

    def remove(self, text: bytes) -> None:
        """Remove a breakpoint, and resume a run that is paused there."""
        uid = _number(json.loads(text), self._requests)
        del self._requests[uid]
        self._apply()
        self._resume_at(uid)

    def unlock(self, text: bytes) -> None:
        """Resume a run that is paused at a breakpoint."""
        described = json.loads(text)
        uid = _number(described, self._requests)
        if described["desired_status"] in _OUTCOMES:
            raise ValueError("outcomes are forced on the page of --control")
        if described["remove_when_done"] or self._requests[uid]["once"]:
            del self._requests[uid]
            self._apply()
        self._resume_at(uid)

    def dump(self) -> bytes:
        """All breakpoints."""
        same = {"mode": _BREAKPOINT, "position": _BEFORE, "desired_status": "SKIPPED"}
        return json.dumps(
            [{"uid": uid, **request, **same} for uid, request in self._requests.items()]
        ).encode()

    def remove_all(self) -> None:
        """Remove all breakpoints, and resume a run that is paused at one."""
        self._requests.clear()
        self._resume_all()

    def disable(self) -> None:
        """Keep all breakpoints, but disable them."""
        for request in self._requests.values():
            request["enabled"] = False
        self._resume_all()

    def set_silent(self, silent: bool) -> None:
        """Disable the breakpoints of a client that is silent; a paused run stays paused."""
        if silent != self._silent:
            self._silent = silent
            self._apply()

    def _apply(self) -> None:
        for uid, hook in self._hooks.items():
            request = self._requests.get(uid)
            hook.groot_stops = request is not None and request["enabled"] and not self._silent

    def _resume_all(self) -> None:
        self._apply()
        for uid in self._hooks:
            self._resume_at(uid)

    def _resume_at(self, uid: int) -> None:
        """Resume the run if it is paused at a node; not after an emergency stop."""
        state = self._control.state
        if self._hooks[uid].waiting and not state.emergency and state.why != ACKNOWLEDGED:
            self._control.resume()


def _number(described: dict[str, Any], known: dict[int, Any]) -> int:
    uid = described["uid"]
    if not isinstance(uid, int) or uid not in known:
        raise ValueError("Node ID not found")
    return uid
