"""The process that holds the connection to the hand.

Reading the hand keeps Python's interpreter lock until the hand answers. So the hand has a process
of its own beside that of the arm.
"""

from __future__ import annotations

import json
import sys
import threading
import time
from typing import Any

from hw.clock import stopwatch
from hw.panda.explanations import explain
from hw.panda.generation import load_library
from hw.panda.records import HAND_READING, HandReading
from hw.processes.child import Parent, Request, claim, leave, still_alive
from hw.processes.mailbox import Mailbox, open_memory

_NAP = 0.02
"""Between two readings [s]."""
_CONNECTING = 20.0
"""[s]"""
_HOMED = 0.05
"""A hand that has not been homed tells a smaller opening than this [m]."""
_CLOSED = 2e-3
"""A width below this means: until something resists [m]."""
_ANY = 0.1
"""Tolerance of a grasp that allows every width [m]."""
_REACHED = 2e-3
"""[m]"""
MEMORY = 1


class HandProcess:
    """The hand's connection.

    Args:
        library: of the vendor.
        address: of the arm that carries the hand.
        speed: of the fingers [m/s].
        memory: descriptor of the shared memory.
    """

    def __init__(self, library: Any, address: str, speed: float, memory: int) -> None:
        self._readings = Mailbox(open_memory(memory), 0, HAND_READING)
        self._speed = speed
        self._hand = library.Gripper(address)
        self._state = self._hand.read_once()
        if self._state.max_width < _HOMED:
            still_alive(3.0 * _CONNECTING)
            self._hand.homing()
        self.publish()

    def publish(self) -> None:
        """Read the hand and tell."""
        state = self._state = self._hand.read_once()
        HandReading(
            stamp=stopwatch(),
            width=state.width,
            opening=state.max_width,
            is_grasped=state.is_grasped,
            temperature=state.temperature,
        ).put(self._readings)

    def stop(self) -> None:
        """Stop the fingers where they are."""
        self._hand.stop()

    def grip(self, width: float, force: float) -> str:
        """Move the fingers; why they did not do it, if so.

        Closed means: until something resists, and then to hold it. Whether it did is told by the
        width, not by what the hand says of a grasp. If something is in the way of any other width,
        it is held, too.
        """
        hand, closing = self._hand, width < self._state.width
        if closing and width < _CLOSED:
            hand.grasp(0.0, self._speed, force, _ANY, _ANY)
            return ""
        wanted = min(width, self._state.max_width)
        if hand.move(wanted, self._speed):
            return ""
        self.publish()
        reached = self._state.width
        if closing and reached > wanted:
            hand.grasp(reached, self._speed, force, _ANY, _ANY)
            return ""
        if abs(reached - wanted) <= _REACHED:
            return ""
        return f"the fingers stopped at {reached * 1e3:.0f} mm instead of {wanted * 1e3:.0f} mm"


def main() -> None:
    """Serve one parent; arguments: address, settings as JSON, descriptor of the shared memory."""
    address, settings, memory = sys.argv[1], json.loads(sys.argv[2]), int(sys.argv[3])
    hands: list[HandProcess] = []

    def at_once(request: Request) -> bool:
        if request["do"] != "stop":
            return False
        if hands:
            try:
                hands[0].stop()
            except RuntimeError as error:
                print(explain(error), file=sys.stderr)
        return True

    parent = Parent(at_once)
    try:
        library = load_library()
        parent.tell(loaded=True)
        if other := claim("hand", address):
            parent.tell(error=other)
            leave(1)
        still_alive(_CONNECTING)
        hand = HandProcess(library, address, settings["speed"], memory)
        hands.append(hand)
        parent.tell(ready=True)
        threading.Thread(target=_work, args=(hand, parent), daemon=True).start()
        while parent.commands():
            still_alive()
            hand.publish()
            time.sleep(_NAP)
    except Exception as error:
        parent.tell(error=explain(error))
        leave(1)
    leave()


def _work(hand: HandProcess, parent: Parent) -> None:
    """Do what takes time, one after the other."""
    while True:
        if request := parent.request(patience=1.0):
            try:
                parent.answer(request, hand.grip(request["width"], request["force"]))
            except RuntimeError as error:
                parent.answer(request, explain(error))
