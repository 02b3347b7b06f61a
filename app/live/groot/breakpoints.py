"""The hooks that a Groot2 client wishes for: breakpoints and replaced outcomes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, NamedTuple

from py_trees.common import Status

from app.live.operator import Act, Control, Hook, Side

_PAUSE, _REPLACE = 0, 1
_OUTCOMES = {"SUCCESS": Status.SUCCESS, "FAILURE": Status.FAILURE}


class _Wish(NamedTuple):
    """A hook as the client described it."""

    enabled: bool
    mode: int
    once: bool
    desired_status: str


class Breakpoints:
    """Makes the hooks of a tree do what the client asks for; used by one thread.

    Requests and the list are JSON. A request that makes no sense raises ValueError, KeyError or
    TypeError, with a text for the client.

    Args:
        hooks: one a node; its number is its place, from 1. What they do already, they keep doing.
        control: lets the run go on.
    """

    def __init__(self, hooks: Sequence[Hook], control: Control) -> None:
        self._hooks = dict(enumerate(hooks, start=1))
        self._standing = {uid: dict(hook.acts) for uid, hook in self._hooks.items()}
        self._control = control
        self._wishes: dict[tuple[int, Side], _Wish] = {}
        self._silent = False

    def insert(self, text: bytes) -> None:
        """Add a hook, or several."""
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

    def remove(self, text: bytes) -> None:
        """Remove a hook; a run that waits there goes on."""
        uid, side = self._known(json.loads(text))
        del self._wishes[uid, side]
        self._apply(uid)
        self._let_go(uid)

    def unlock(self, text: bytes) -> None:
        """Let a run go on that waits at a hook, with another outcome if the client says so."""
        described = json.loads(text)
        uid, side = self._known(described)
        if described["remove_when_done"] or self._wishes[uid, side].once:
            del self._wishes[uid, side]
            self._apply(uid)
        self._let_go(uid, _OUTCOMES.get(str(described["desired_status"])))

    def dump(self) -> bytes:
        """All hooks."""
        return json.dumps(
            [
                {"uid": uid, "position": side.value, **wish._asdict()}
                for (uid, side), wish in self._wishes.items()
            ]
        ).encode()

    def remove_all(self) -> None:
        """Remove all hooks; a run that waits at one goes on."""
        self._wishes.clear()
        self._let_all_go()

    def disable(self) -> None:
        """Keep all hooks, but let none act."""
        self._wishes = {at: wish._replace(enabled=False) for at, wish in self._wishes.items()}
        self._let_all_go()

    def replaced(self, uid: int, side: Side) -> None:
        """A hook has acted; one that replaces only once is done with it."""
        wish = self._wishes.get((uid, side))
        if wish is not None and wish.once and wish.mode == _REPLACE:
            del self._wishes[uid, side]

    def set_silent(self, silent: bool) -> None:
        """Whether the client says nothing: its hooks do not act, and a paused run stays paused."""
        if silent != self._silent:
            self._silent = silent
            for uid in self._hooks:
                self._apply(uid)

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

    def _let_all_go(self) -> None:
        for uid in self._hooks:
            self._apply(uid)
            self._let_go(uid)

    def _let_go(self, uid: int, answer: Status | None = None) -> None:
        """Go on if the run waits at a node."""
        hook = self._hooks[uid]
        if hook.waiting:
            hook.answer = answer
            self._control.resume()
