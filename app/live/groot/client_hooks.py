"""Hooks that a Groot2 client inserts: breakpoints and replaced outcomes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

from py_trees.common import Status

from app.live.operator import ACKNOWLEDGED, Control, Hook, HookAction, Side

_BREAKPOINT, _REPLACE = 0, 1
_OUTCOMES = {"SUCCESS": Status.SUCCESS, "FAILURE": Status.FAILURE}
_NO_OUTCOMES = ("SKIPPED", "IDLE", "RUNNING")


class _HookRequest(NamedTuple):
    """A hook as the client described it."""

    enabled: bool
    mode: int
    once: bool
    desired_status: str


class ClientHooks:
    """Sets the actions of a tree's hooks as the client requests; used by one thread.

    Requests and the list are JSON. An invalid or forbidden request raises an exception with a text
    for the client, and changes nothing.

    Args:
        hooks: one per node; a node's number is its position, from 1. Existing actions are kept.
        control: resumes the run.
        may_replace: whether clients may replace the outcomes of nodes.
    """

    def __init__(
        self, hooks: Sequence[Hook], control: Control, *, may_replace: bool = False
    ) -> None:
        self._hooks = dict(enumerate(hooks, start=1))
        self._before: dict[tuple[int, Side], HookAction | None] = {}
        self._control = control
        self._may_replace = may_replace
        self._requests: dict[tuple[int, Side], _HookRequest] = {}
        self._silent = False

    def insert(self, text: bytes) -> None:
        """Add one hook or several."""
        described = json.loads(text)
        several = described if isinstance(described, list) else [described]
        requests = {self._position(one): self._request(one) for one in several}
        self._requests |= requests
        for uid, _ in requests:
            self._apply(uid)

    def remove(self, text: bytes) -> None:
        """Remove a hook, and resume a run that is paused there."""
        uid, side = self._existing(json.loads(text))
        del self._requests[uid, side]
        self._apply(uid)
        self._resume_at(uid)

    def unlock(self, text: bytes) -> None:
        """Resume a run that is paused at a hook, with the outcome that the client chose, if any."""
        described = json.loads(text)
        uid, side = self._existing(described)
        answer = self._outcome(described["desired_status"])
        if described["remove_when_done"] or self._requests[uid, side].once:
            del self._requests[uid, side]
            self._apply(uid)
        self._resume_at(uid, answer)

    def dump(self) -> bytes:
        """All hooks."""
        return json.dumps(
            [
                {"uid": uid, "position": side.value, **request._asdict()}
                for (uid, side), request in self._requests.items()
            ]
        ).encode()

    def remove_all(self) -> None:
        """Remove all hooks, and resume a run that is paused at one."""
        self._requests.clear()
        self._resume_all()

    def disable(self) -> None:
        """Keep all hooks, but disable them."""
        self._requests = {key: r._replace(enabled=False) for key, r in self._requests.items()}
        self._resume_all()

    def replaced(self, uid: int, side: Side) -> None:
        """Remove a hook that has replaced an outcome and acts only once."""
        request = self._requests.get((uid, side))
        if request is not None and request.once and request.mode == _REPLACE:
            del self._requests[uid, side]
            self._before.pop((uid, side), None)

    def set_silent(self, silent: bool) -> None:
        """Disable the hooks of a client that is silent; a paused run stays paused."""
        if silent != self._silent:
            self._silent = silent
            for uid in self._hooks:
                self._apply(uid)

    def _request(self, described: dict[str, Any]) -> _HookRequest:
        mode, status = described["mode"], described["desired_status"]
        if mode not in (_BREAKPOINT, _REPLACE):
            raise ValueError("Hook mode not recognized")
        self._outcome(status, wanted=mode == _REPLACE)
        return _HookRequest(
            enabled=bool(described["enabled"]),
            mode=mode,
            once=bool(described["once"]),
            desired_status=str(status),
        )

    def _outcome(self, status: object, *, wanted: bool = True) -> Status | None:
        """The outcome that a client asks for; None if it asks for none."""
        if status not in (*_OUTCOMES, *_NO_OUTCOMES):
            raise ValueError("Status not recognized")
        outcome = _OUTCOMES.get(str(status)) if wanted else None
        if outcome is not None and not self._may_replace:
            raise ValueError("replacing outcomes is off: run the task with --groot2-control")
        return outcome

    def _position(self, described: dict[str, Any]) -> tuple[int, Side]:
        uid, side = described["uid"], Side(described["position"])
        if not isinstance(uid, int) or uid not in self._hooks:
            raise ValueError("Node ID not found")
        return uid, side

    def _existing(self, described: dict[str, Any]) -> tuple[int, Side]:
        position = self._position(described)
        if position not in self._requests:
            raise ValueError("Node ID not found")
        return position

    def _apply(self, uid: int) -> None:
        """Set a hook's actions to the client's; restore the former ones where it has none."""
        actions = self._hooks[uid].actions
        for key in ((uid, side) for side in Side):
            if (wanted := self._wanted(key)) is not None:
                self._before.setdefault(key, actions.get(key[1]))
                actions[key[1]] = wanted
            elif key in self._before:
                actions.pop(key[1], None)
                if (before := self._before.pop(key)) is not None:
                    actions[key[1]] = before

    def _wanted(self, key: tuple[int, Side]) -> HookAction | None:
        """The action that the client wants, if it wants one and is there."""
        request = self._requests.get(key)
        if request is None or not request.enabled or self._silent:
            return None
        outcome = _OUTCOMES.get(request.desired_status) if request.mode == _REPLACE else None
        if outcome is None and request.mode != _BREAKPOINT:
            return None
        return HookAction(replace_with=outcome, once=request.once)

    def _resume_all(self) -> None:
        for uid in self._hooks:
            self._apply(uid)
            self._resume_at(uid)

    def _resume_at(self, uid: int, answer: Status | None = None) -> None:
        """Resume the run if it is paused at a node; not after an emergency stop."""
        hook, state = self._hooks[uid], self._control.state
        if hook.waiting and not state.emergency and state.why != ACKNOWLEDGED:
            hook.answer = answer
            self._control.resume()
