"""What a person or a test may do to the emulated robot while it runs: one line of words each."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from config import suggest
from hw.clock import stopwatch
from hw.emulators.panda.arm import Seen
from hw.emulators.panda.parts import PERIOD, FreeFingers
from hw.emulators.panda.server import PandaServer
from hw.emulators.panda.wire import ERRORS
from hw.panda import Mode


def _reflex(server: PandaServer, name: str = "cartesian_reflex") -> None:
    if name not in ERRORS:
        raise ValueError(f"no error is called {name}; {suggest(name, ERRORS)}")
    server.arm.reflex(name)


def _line(name: str) -> Callable[..., None]:
    def change(server: PandaServer, share: str = "0", seconds: str = "0.005") -> None:
        setattr(server.line, name, float(share))
        server.line.delay = float(seconds)

    return change


def _freeze(server: PandaServer, seconds: str = "1") -> None:
    server.frozen_at = stopwatch()
    server.frozen_until = server.frozen_at + float(seconds)


def _unplug(server: PandaServer, seconds: str = "1") -> None:
    server.line.unplugged_until = stopwatch() + float(seconds)


def _block(server: PandaServer, width: str = "") -> None:
    fingers = server.hand.fingers
    if not isinstance(fingers, FreeFingers):
        raise ValueError("a world stands behind these fingers")
    fingers.block = float(width) if width else None


def _rush(server: PandaServer, faster: str = "0") -> None:
    server.arm.rush = float(faster)


def _hold(server: PandaServer) -> None:
    server.hand.is_grasped = True


def _mode(mode: Mode) -> Callable[[PandaServer], None]:
    return lambda server: server.arm.switch(mode)


def _release(server: PandaServer) -> None:
    if server.arm.mode in (Mode.USER_STOPPED, Mode.OTHER, Mode.GUIDING):
        server.arm.switch(Mode.IDLE)


def _patience(server: PandaServer, packets: str = "20") -> None:
    server.arm.most_lost = int(packets)


def _forget(server: PandaServer) -> None:
    server.arm.seen, server.missed = Seen(), 0


ACTIONS: dict[str, tuple[Callable[..., None], str]] = {
    "reflex": (_reflex, "[NAME]  the arm stops itself, cartesian_reflex if no other is named"),
    "stop": (_mode(Mode.USER_STOPPED), "a person presses the stop button"),
    "release": (_release, "the button is released, joints are unlocked, the arm let go"),
    "lock": (_mode(Mode.OTHER), "the joints are locked"),
    "guide": (_mode(Mode.GUIDING), "a person takes the arm by the hand"),
    "freeze": (_freeze, "[SECONDS]  the whole robot stands still"),
    "unplug": (_unplug, "[SECONDS]  nothing goes over the cable; the robot goes on"),
    "drop": (_line("dropped"), "SHARE  of the packets get lost"),
    "delay": (_line("delayed"), "SHARE [SECONDS]  of the packets arrive late"),
    "block": (_block, "[WIDTH]  something of that width lies between the fingers, or nothing"),
    "blackout": (lambda server: server.hand.black_out(), "the hand loses its power for a moment"),
    "hold": (_hold, "the hand says that it holds something"),
    "rush": (_rush, "[RAD/S]  the first joint turns so much faster in a motion than it is told"),
    "patience": (_patience, "PACKETS  lost in a row end a motion"),
    "forget": (_forget, "what was seen so far"),
    "tell": (lambda server: None, "what was seen so far"),
}
"""By name: what it does, and what to say of it."""


def act(server: PandaServer, line: str) -> dict[str, Any]:
    """Do one line of words; what is to be told, as JSON."""
    name, *words = line.split() or [""]
    if name not in ACTIONS:
        return {"error": f"no such thing as `{name}`; {suggest(name, ACTIONS)}"}
    try:
        ACTIONS[name][0](server, *words)
    except (TypeError, ValueError) as error:
        return {"error": str(error)}
    arm = server.arm
    return {
        "did": name,
        "now": stopwatch(),
        "mode": arm.mode.name,
        "errors": sorted(arm.errors),
        "last_errors": sorted(arm.last_errors),
        "has_commander": server.has_commander,
        "resting": arm.resting * PERIOD,
        "still": server.still,
        "q": arm.joints.q,
        "qd": arm.joints.qd,
        "width": server.hand.fingers.width,
        "is_grasped": server.hand.is_grasped,
        "is_homed": server.hand.is_homed,
        "homings": server.hand.homings,
        "stops": server.hand.stops,
        "recoveries": arm.recoveries,
        "missed": server.missed,
        "milliseconds": arm.number,
        **asdict(arm.seen),
    }


def dumps(told: dict[str, Any]) -> str:
    """One line of JSON."""
    return json.dumps(told)
