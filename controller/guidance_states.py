"""The states of guidance towards one goal, the table of its transitions, and what was tried."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum
from math import cos
from typing import NamedTuple, TypeAlias

import numpy as np
from pinocchio import SE3

from config.poses import MapPose
from controller.command import PoseGoal
from controller.stance.search import StanceSearch
from controller.stance.stance import Stance

_JUMP = 0.1  # a goal that moves this far in one period is a new goal [m] ...
_TURN = 0.3  # ... or turns this far [rad]
_RISE = 0.05  # a goal that has drifted up or down this far needs another stance [m] ...
_TILT = 0.97  # ... or has tilted this far [cosine of the angle]


class Unjudged(NamedTuple):
    """There is no goal, or a new one that was not judged yet."""


class Unreachable(NamedTuple):
    """The robot rests: it cannot get to the goal."""

    why: str


class Alone(NamedTuple):
    """The end effector moves to the goal without a stance."""


class Searching(NamedTuple):
    """The robot rests while a stance is searched."""

    search: StanceSearch
    for_detour: bool  # whether that stance is a detour
    periods: int = 0  # since it rests, in which the goal may have changed


class Approaching(NamedTuple):
    """Base and arm are led to a stance."""

    stance: Stance
    is_detour: bool
    """Whether the stance is a way out of a local minimum, on which the end effector waits."""


class Replacing(NamedTuple):
    """Base and arm are led to a stance as in `Approaching` while another is searched."""

    stance: Stance
    search: StanceSearch
    is_detour: bool  # of `stance`
    for_detour: bool  # whether the stance that is searched is a detour


State: TypeAlias = Unjudged | Unreachable | Alone | Searching | Approaching | Replacing


class Event(Enum):
    """The table of transitions: an event, as docs/controller.md draws it, and what it changes.

    Besides, every state becomes `Unjudged` when the goal is forgotten or must be judged anew.
    """

    OUT_OF_REACH = "out of reach", {Unjudged: Unreachable}
    NEAR = "near, or straight", {Unjudged: Alone}
    SET_OUT = "its stance is known from `next_goal`", {Unjudged: Approaching}
    DRIFTED = "it has drifted from its stance, or obstacles moved", {Unjudged: Replacing}
    FAR = "any other goal", {Unjudged: Searching}
    CHOSEN = "stance found, its dock not yet", {Searching: Replacing}
    FOUND = "stance found", {Searching: Approaching, Replacing: Approaching}
    NONE_FREE = "no stance stands free", {Searching: Unreachable, Replacing: Unreachable}
    NO_WAY = "no way for the base", {Approaching: Searching, Replacing: Searching}
    CUT_OFF = "no way for the base, no detour left", {Approaching: Unreachable}
    STALLED = "no progress", {Approaching: Replacing, Alone: Searching}
    GIVEN_UP = "no progress, no detour left", {Approaching: Alone, Alone: Alone}
    CLOSE = "close, the detour is over", {Approaching: Approaching}

    def __init__(self, words: str, changes: Mapping[type[State], type[State]]) -> None:
        self.words = words
        self.changes = changes  # to the next state, from each in which it happens


class Attempt(NamedTuple):
    """A goal since it was judged, and what was tried for it."""

    first: SE3  # its pose when it was judged
    goal: PoseGoal[MapPose]  # as it is now
    detours_left: int  # number of stances that may still be searched after a failure
    failed: tuple[Stance, ...] = ()  # the stances that led to none

    def has_jumped(self, mTe: MapPose) -> bool:
        """Whether a pose is that of another goal, not of this one after a period."""
        before = self.goal.target
        moved = mTe.translation - before.translation
        cosine = (float(np.vdot(mTe.rotation, before.rotation)) - 1.0) / 2.0
        return float(moved @ moved) > _JUMP**2 or cosine < cos(_TURN)

    def has_drifted(self, mTe: MapPose) -> bool:
        """Whether a goal has crept to a height or tilt where its stance does not reach it."""
        rise = float(mTe.translation[2] - self.first.translation[2])
        tilt = float(mTe.rotation[2] @ self.first.rotation[2])
        return abs(rise) > _RISE or tilt < _TILT

    def failing(self, stance: Stance | None) -> Attempt:
        """After a stance, or the end effector alone, has led to none."""
        failed = self.failed if stance is None else (*self.failed, stance)
        return self._replace(failed=failed, detours_left=max(0, self.detours_left - 1))


NOTHING_TRIED = Attempt(SE3.Identity(), PoseGoal(target=SE3.Identity()), 0)  # without a goal
