"""What can be done to an emulated Frankie while it runs: one line of words each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
from pinocchio import SE3, SE3ToXYZQUAT

from config import suggest
from hw.clock import stopwatch
from hw.emulators.frankie.emulator import FrankieEmulator

Told = dict[str, Any]


def _tell(emulator: FrankieEmulator) -> Told:
    world = emulator.world
    with world.lock:
        truth = world.truth
        return {
            "robot": emulator.robot,
            "world": world.name,
            "scene": world.scene,
            "seed": world.seed,
            "now": world.clock.now(),
            "stamp": stopwatch() - (world.clock.now() - world.body.now),
            "base": world.pose(),
            "twist": world.twist(),
            "wanted": emulator.base.controller.wanted,
            "still": stopwatch() - emulator.base.controller.moved_at,
            "q": world.body.q.tolist(),
            "qd": world.body.qd.tolist(),
            "poses": {one.name: SE3ToXYZQUAT(one.pose).tolist() for one in truth.objects},
            "supports": dict(truth.supports()),
            "touches": [asdict(one) for one in truth.touches],
            "bumped": world.bumped,
        }


def _arm(emulator: FrankieEmulator, *words: str) -> Told:
    return emulator.do_to_arm(" ".join(words))


def _press(emulator: FrankieEmulator) -> Told:
    with emulator.base.held() as base:
        base.press()
    return emulator.do_to_arm("stop")


def _release(emulator: FrankieEmulator) -> Told:
    with emulator.base.held() as base:
        base.release()
    return emulator.do_to_arm("release")


def _button(emulator: FrankieEmulator) -> Told:
    with emulator.base.held() as base:
        base.push_button()
    return {}


def _lost(emulator: FrankieEmulator, is_lost: str = "yes") -> Told:
    emulator.base.options.lost = is_lost == "yes"
    return {}


def _freeze(emulator: FrankieEmulator, is_frozen: str = "yes") -> Told:
    emulator.base.freeze(is_frozen == "yes")
    return {}


def _break(emulator: FrankieEmulator) -> Told:
    emulator.base.break_off()
    return {}


def _noise(emulator: FrankieEmulator, is_noisy: str = "yes") -> Told:
    options = emulator.base.options
    options.pieces = options.garbage = is_noisy == "yes"
    return {}


def _dock(emulator: FrankieEmulator, *, leave: bool = False) -> Told:
    with emulator.base.held() as base:
        base.dock(stopwatch(), leave=leave)
    return {}


def _delay(emulator: FrankieEmulator, share: str = "0.01", seconds: str = "0.005") -> Told:
    emulator.base.options.jitter = float(seconds) if float(share) > 0.0 else 0.0
    return emulator.do_to_arm(f"delay {float(share)} {float(seconds)}")


def _blind(emulator: FrankieEmulator, seconds: str = "1") -> Told:
    emulator.blind(float(seconds))
    return {}


def _stare(emulator: FrankieEmulator, is_frozen: str = "yes") -> Told:
    emulator.camera.freeze(is_frozen == "yes")
    return {}


def _board(emulator: FrankieEmulator, path: str = "board.png", width: str = "0.28") -> Told:
    emulator.world.show(path, float(width))
    return {}


def _put(emulator: FrankieEmulator, *words: str) -> Told:
    name, place = " ".join(words[:-3]), np.array([float(one) for one in words[-3:]])
    with emulator.world.lock:
        pose = emulator.world.truth.find(name).pose
        emulator.world.truth.put(name, SE3(pose.rotation, place))
    return {}


WORDS: dict[str, tuple[Callable[..., Told], str]] = {
    "tell": (_tell, "where everything is"),
    "arm": (_arm, "WORDS  to the arm, as `arm reflex` or `arm unplug 2`"),
    "stop": (_press, "the emergency stop of base and arm is pressed"),
    "release": (_release, "and released"),
    "button": (_button, "a person switches the motors of the base on, at the base"),
    "lost": (_lost, "[yes|no]  the base does not know where it is"),
    "freeze": (_freeze, "[yes|no]  the server of the base does nothing"),
    "break": (_break, "the connections of the base are reset"),
    "noise": (_noise, "[yes|no]  what the base sends comes in pieces, with stray bytes between"),
    "dock": (_dock, "the base is sent to its dock, and lets nobody else in"),
    "undock": (partial(_dock, leave=True), "and away from it"),
    "delay": (_delay, "[SHARE SECONDS]  of the arm's packets, and up to so long of the base's"),
    "blind": (_blind, "[SECONDS]  the camera is unplugged"),
    "stare": (_stare, "[yes|no]  the camera is plugged in and sends no images"),
    "board": (_board, "[FILE WIDTH]  a printed picture lies before the camera, so wide [m]"),
    "put": (_put, "NAME X Y Z  an object is put elsewhere"),
}
"""By name: what it does, and what to say of it."""


def act(emulator: FrankieEmulator, line: str) -> Told:
    """Do one line of words; what is to be told, as JSON."""
    name, *words = line.split() or [""]
    if name not in WORDS:
        return {"error": f"no such thing as `{name}`; {suggest(name, WORDS)}"}
    try:
        return {"did": name, **WORDS[name][0](emulator, *words)}
    except (TypeError, ValueError, KeyError) as error:
        return {"error": str(error)}
