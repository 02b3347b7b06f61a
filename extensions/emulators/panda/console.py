"""Console of the emulated Panda: commands as lines of text, state as lines of JSON."""

import json
import queue
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from typing import Any

from config import UserError, suggest
from drivers.panda import Mode
from extensions.emulators.common import Words, act, be_prompt
from extensions.emulators.panda.emulated_arm import Seen
from extensions.emulators.panda.emulator import PandaServer
from extensions.emulators.panda.joints_and_fingers import (
    PERIOD,
    Fingers,
    FreeFingers,
    Joints,
    LaggedJoints,
)
from extensions.emulators.panda.wire import ERRORS, VERSION
from hw import stopwatch

_PRIORITY = 10  # real-time priority


def _reflex(server: PandaServer, name: str = "cartesian_reflex") -> None:
    if name not in ERRORS:
        raise ValueError(f"no error is called {name}; {suggest(name, ERRORS)}")
    server.arm.reflex(name)


def _set(part: str, name: str, kind: type, default: Any) -> Callable[..., None]:
    return lambda server, value=default: setattr(getattr(server, part), name, kind(value))


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


def _mode(mode: Mode) -> Callable[[PandaServer], None]:
    return lambda server: server.arm.switch(mode)


def _release(server: PandaServer) -> None:
    if server.arm.mode in (Mode.USER_STOPPED, Mode.OTHER, Mode.GUIDING):
        server.arm.switch(Mode.IDLE)


def _forget(server: PandaServer) -> None:
    server.arm.seen, server.missed = Seen(), 0


ACTIONS: Words = {
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
    "hold": (
        lambda server: setattr(server.hand, "is_grasped", True),
        "the hand says that it holds something",
    ),
    "rush": (
        _set("arm", "rush", float, 0),
        "[RAD/S]  the first joint turns so much faster in a motion than it is told",
    ),
    "patience": (_set("arm", "most_lost", int, 20), "PACKETS  lost in a row end a motion"),
    "forget": (_forget, "what was seen so far"),
    "tell": (lambda server: None, "what was seen so far"),
}


def _act(server: PandaServer, line: str) -> dict[str, Any]:
    """Do one command; the state after it."""
    did = act(ACTIONS, server, line)
    if "error" in did:
        return did
    arm = server.arm
    return {
        **did,
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


def serve(
    host: str,
    *,
    joints: Joints | None = None,
    fingers: Fingers | None = None,
    version: int = VERSION,
    as_reported: Sequence[str] = (),
    lines: Iterable[str] = (),
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Run a Panda at an address of this computer until `lines`, words of `ACTIONS`, end."""
    try:
        body: Joints = LaggedJoints() if joints is None else joints
        hand: Fingers = FreeFingers() if fingers is None else fingers
        server = PandaServer(host, body, hand, version, as_reported)
    except OSError as error:
        raise UserError(f"no robot can be emulated at {host}: {error.strerror}") from None
    asked: queue.SimpleQueue[str | None] = queue.SimpleQueue()

    def listen() -> None:
        for line in lines:
            asked.put(line)
        asked.put(None)

    over = False

    def answer() -> None:
        nonlocal over
        if asked.empty():
            return
        line = asked.get()
        if line is None:
            over = True
        else:
            say(json.dumps(_act(server, line)))

    threading.Thread(target=listen, daemon=True).start()
    be_prompt(_PRIORITY)
    say(json.dumps({"did": "begin"}))
    try:
        server.run(lambda: over, answer)
    finally:
        server.close()
