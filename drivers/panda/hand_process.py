"""The process that holds the connection to the hand.

Reading the hand keeps Python's interpreter lock until the hand answers, so it has a process of its
own. Blocked fingers go on for minutes, and the vendor's library waits for them: the reading thread
monitors the motion and stops it in time.
"""

import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from math import inf
from typing import Any

from drivers.panda.explanations import explain, explain_connecting
from drivers.panda.library import load_library
from drivers.panda.records import CLOSED, HAND_READING, HOMED, REACHED, HandReading
from drivers.processes.child import EndError, Parent, Request, serve, still_alive
from drivers.processes.mailbox import Mailbox, open_memory
from hw.clock import stopwatch

_NAP = 0.02  # between two readings [s]
_CONNECTING = 20.0  # timeout of connecting [s]
HOMING = 30.0  # timeout of homing; 6 to 15 s are usual [s]
_WIDEST = 0.1  # no hand opens wider [m]
_MOVING, _GRASPING = 3.0, 9.0  # timeouts of a move and a grasp, in addition to the travel time [s]
_BLOCKED, _STILL = 1.5, 5e-4  # at rest for so long [s] within [m] in a move
_STOPPING = 2.0  # timeout of a stop [s]
_ANY = 0.1  # tolerance of a grasp that allows every width [m]
_SAME = 1e-3  # tolerance of the width of a held object [m]
NOT_HOMED = (
    "it was not homed since it was switched on: `run` or a recovery homes it, it closes and opens"
)
_IN_THE_WAY = "the fingers stopped before the width that they were told: something is in their way"
_STOPPED = "the fingers were stopped on their way"
_LATE = "the fingers did not end their way in time and were stopped: see what is between them"
_UNSTOPPABLE = "the fingers go on and do not listen to a stop: see what is between them"
MEMORY = 1


def patience(speed: float) -> float:
    """Timeout of a grip at a speed of the fingers [m/s]: a move, a stop and a grasp [s]."""
    return 2.0 * (_WIDEST / speed + _STOPPING) + _MOVING + _GRASPING


@dataclass
class _Motion:
    limit: float  # timeout [s]
    rest: float  # longest time at rest [s]
    width: float  # when they last moved [m]
    began: float = field(default_factory=stopwatch)
    moved: float = field(default_factory=stopwatch)
    stopped: float = inf
    why: str = ""  # why it was stopped


class HandProcess:
    """The connection to the hand."""

    def __init__(self, library: Any, address: str, speed: float, memory: int) -> None:
        self._readings = Mailbox(open_memory(memory), 0, HAND_READING)
        self._reading = threading.Lock()
        self._speed = speed
        self._hand = library.Gripper(address)
        self._motion: _Motion | None = None
        self._stops = threading.Event()
        threading.Thread(target=self._stop_when_told, daemon=True).start()
        self._state = state = self.publish()
        self._held = state.width if state.is_grasped else None  # width of the last grasp [m]

    def publish(self) -> Any:
        """Read and publish the state."""
        with self._reading:
            self._state = state = self._hand.read_once()
            reading = HandReading(
                stopwatch(), state.width, state.max_width, state.is_grasped, state.temperature
            )
            self._readings.put(*reading)
        return state

    def watch(self) -> None:
        """Read the hand; stop late or blocked fingers. RuntimeError: they cannot be stopped."""
        motion = self._motion
        try:
            width = self.publish().width
        except RuntimeError:
            if motion is None or motion.limit != HOMING:  # it may be silent while homing
                raise
            return
        if motion is None:
            return
        now = stopwatch()
        if abs(width - motion.width) > _STILL:
            motion.width, motion.moved = width, now
        if now - motion.stopped > _STOPPING:
            raise RuntimeError(_UNSTOPPABLE)
        if motion.why:
            return
        if now - motion.moved > motion.rest:
            self.stop(_IN_THE_WAY)
        elif now - motion.began > motion.limit:
            self.stop(_LATE)

    def stop(self, why: str = _STOPPED) -> None:
        """Stop the fingers where they are; returns at once."""
        if (motion := self._motion) is not None:
            motion.why, motion.stopped = why, stopwatch()
        self._held = None
        self._stops.set()

    def _stop_when_told(self) -> None:
        """On a thread of its own from the beginning: later the computer may start no more."""
        while self._stops.wait():
            self._stops.clear()
            self._stop()

    def _stop(self) -> None:
        try:
            self._hand.stop()
        except RuntimeError as error:
            print(explain(error), file=sys.stderr)

    def end(self) -> None:
        """Stop a current motion."""
        if self._motion is not None:
            self._stop()

    def home(self) -> str:
        """Home the hand; why not."""
        why = self._move(self._hand.homing, HOMING, inf, self._state.width)
        if why or self.publish().max_width >= HOMED:
            return why
        return "homing has found no opening: see what is between the fingers"

    def grip(self, width: float, force: float) -> str:
        """Move the fingers; why not. What resists is held, whatever the hand reports of a grasp."""
        hand, speed, before = self._hand, self._speed, self._state
        if before.max_width < HOMED:
            return NOT_HOMED
        wanted = min(width, before.max_width)
        closing = wanted < before.width
        if closing and self._held is not None and abs(before.width - self._held) <= _SAME:
            return ""  # a second grasp of the same would wait, and fail
        self._held, why = None, ""
        way, goal = _WIDEST / speed, 0.0
        if not closing or wanted >= CLOSED:
            move = partial(hand.move, wanted, speed)
            why = self._move(move, way + _MOVING, _BLOCKED, before.width)
            goal = self.publish().width
            if abs(goal - wanted) <= REACHED:
                return ""
            if not closing or goal < wanted or why == _STOPPED:
                return why
        grasp = partial(hand.grasp, goal, speed, force, _ANY, _ANY)
        why = self._move(grasp, way + _GRASPING, inf, goal or before.width)
        state = self.publish()
        if why == _IN_THE_WAY:
            why = ""  # the width tells
        if not why or state.is_grasped:
            self._held = state.width
            return ""
        return why

    def _move(self, motion: Callable[[], bool], limit: float, rest: float, width: float) -> str:
        """Run a motion until it ends or is stopped; why it failed."""
        self._motion = watched = _Motion(limit, rest, width)
        try:
            return "" if motion() else watched.why or _IN_THE_WAY
        except RuntimeError as error:
            return watched.why or explain(error)
        finally:
            self._motion = None


def main() -> None:
    """Serve one parent."""
    hands: list[HandProcess] = []

    def at_once(request: Request) -> bool:
        if request["do"] == "stop":
            for hand in hands:
                hand.stop()
        return bool(request["do"] == "stop")

    def work(parent: Parent, address: str, settings: Any, memory: int) -> None:
        library = load_library()
        parent.tell(loaded=True)
        parent.claim(f"hand {address}")
        still_alive(_CONNECTING)
        try:
            hand = HandProcess(library, address, settings["speed"], memory)
        except RuntimeError as error:
            raise EndError(explain_connecting(error)) from error
        hands.append(hand)
        parent.tell(ready=True)
        threading.Thread(target=_work, args=(hand, parent), daemon=True).start()
        while parent.commands():
            still_alive()
            hand.watch()
            time.sleep(_NAP)
        hand.end()

    serve(work, explain, at_once)


def _work(hand: HandProcess, parent: Parent) -> None:
    while not parent.is_gone:
        if request := parent.request(patience=1.0):
            try:
                if request["do"] == "home":
                    why = hand.home()
                else:
                    why = hand.grip(request["width"], request["force"])
            except RuntimeError as error:
                why = explain(error)
            parent.answer(request, why)
