"""Console of the emulated Frankie: commands as lines of text, also over a port; answers in JSON."""

from __future__ import annotations

import json
import socketserver
import sys
import threading
from collections.abc import Callable, Iterable
from dataclasses import asdict
from typing import Any

import numpy as np
from pinocchio import SE3, SE3ToXYZQUAT

from config import UserError
from extensions.emulators.common import Words, act, be_prompt
from extensions.emulators.frankie.emulator import FrankieEmulator
from extensions.emulators.omron import Controller
from hw import stopwatch

_PRIORITY = 5  # real-time priority, below that of the emulated arm

Answer = dict[str, Any]


def _tell(emulator: FrankieEmulator) -> Answer:
    world = emulator.world
    with world.lock:
        truth = world.truth
        return {
            "robot": emulator.robot,
            "world": world.name,
            "scene": world.scene,
            "seed": world.seed,
            "localisation": world.localisation,
            "now": world.clock.now(),
            "stamp": stopwatch() - (world.clock.now() - world.body.now),
            "base": world.pose(),
            "twist": world.twist(),
            "wanted": emulator.base.controller.wanted,
            "still": stopwatch() - emulator.base.controller.moved_at,
            "q": world.body.q.tolist(),
            "qd": world.body.qd.tolist(),
            "poses": {one.name: SE3ToXYZQUAT(one.pose).tolist() for one in truth.objects},
            "touches": [asdict(one) for one in truth.touches],
            "bumped": world.bumped,
        }


def _supports(emulator: FrankieEmulator) -> Answer:
    with emulator.world.lock:
        return {"supports": dict(emulator.world.truth.supports())}


def _arm(emulator: FrankieEmulator, *words: str) -> Answer:
    return emulator.do_to_arm(" ".join(words))


def _press(emulator: FrankieEmulator) -> Answer:
    with emulator.base.held() as base:
        base.press()
    return emulator.do_to_arm("stop")


def _release(emulator: FrankieEmulator) -> Answer:
    with emulator.base.held() as base:
        base.release()
    return emulator.do_to_arm("release")


def _switch(part: str, *names: str) -> Callable[..., None]:
    """Sets options of a part, on or off."""

    def act(emulator: FrankieEmulator, on: str = "yes") -> None:
        for name in names:
            setattr(getattr(emulator, part).options, name, on == "yes")

    return act


def _at_base(action: Callable[[Controller], None]) -> Callable[[FrankieEmulator], None]:
    def act(emulator: FrankieEmulator) -> None:
        with emulator.base.held() as base:
            action(base)

    return act


def _delay(emulator: FrankieEmulator, share: str = "0.01", seconds: str = "0.005") -> Answer:
    emulator.base.options.jitter = float(seconds) if float(share) > 0.0 else 0.0
    return emulator.do_to_arm(f"delay {float(share)} {float(seconds)}")


def _put(emulator: FrankieEmulator, *words: str) -> None:
    name, place = " ".join(words[:-3]), np.array([float(one) for one in words[-3:]])
    with emulator.world.lock:
        pose = emulator.world.truth.find(name).pose
        emulator.world.truth.put(name, SE3(pose.rotation, place))


WORDS: Words = {
    "tell": (_tell, "where everything is"),
    "supports": (_supports, "what carries each object"),
    "arm": (_arm, "WORDS  to the arm, as `arm reflex` or `arm unplug 2`"),
    "stop": (_press, "the emergency stop of base and arm is pressed"),
    "release": (_release, "and released"),
    "button": (
        _at_base(Controller.push_button),
        "a person switches the motors of the base on, at the base",
    ),
    "lost": (_switch("base", "lost"), "[yes|no]  the base does not know where it is"),
    "freeze": (_switch("base", "frozen"), "[yes|no]  the server of the base does nothing"),
    "break": (lambda emulator: emulator.base.break_off(), "the connections of the base are reset"),
    "noise": (
        _switch("base", "pieces", "garbage"),
        "[yes|no]  what the base sends comes in pieces, with stray bytes between",
    ),
    "dock": (_at_base(Controller.dock), "the base is sent to its dock, and lets nobody else in"),
    "undock": (_at_base(Controller.undock), "and away from it"),
    "delay": (_delay, "[SHARE SECONDS]  of the arm's packets, and up to so long of the base's"),
    "blind": (
        lambda emulator, seconds="1": emulator.blind(float(seconds)),
        "[SECONDS]  the camera is unplugged",
    ),
    "stare": (
        _switch("camera", "frozen"),
        "[yes|no]  the camera is plugged in and sends no images",
    ),
    "put": (_put, "NAME X Y Z  an object is put elsewhere"),
    "give": (
        lambda emulator, *words: emulator.world.truth.give(" ".join(words)),
        "NAME  a person holds an object between the fingers, until they have it",
    ),
}


class _Handler(socketserver.StreamRequestHandler):
    server: _Server
    disable_nagle_algorithm = True

    def handle(self) -> None:
        for line in self.rfile:
            answer = act(WORDS, self.server.emulator, line.decode(errors="replace"))
            self.wfile.write(json.dumps(answer).encode() + b"\n")


class _Server(socketserver.ThreadingTCPServer):
    allow_reuse_address = True
    daemon_threads = True

    def __init__(self, emulator: FrankieEmulator) -> None:
        self.emulator = emulator
        super().__init__(emulator.address, _Handler)

    def handle_error(self, request: object, client_address: object) -> None:
        """Ignore clients that disconnect."""


def serve(
    emulator: FrankieEmulator,
    *,
    lines: Iterable[str] = (),
    say: Callable[[str], None] = lambda _: None,
) -> None:
    """Run an emulated Frankie until `lines`, commands of `WORDS`, end; `say` gets lines of JSON."""
    sys.setswitchinterval(1e-3)
    be_prompt(_PRIORITY)
    try:
        server = _Server(emulator)
    except OSError as error:
        text = f"port {emulator.address[1]}: {error.strerror}; choose another one"
        raise UserError(text) from None
    with server, emulator:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        say(json.dumps({"did": "begin"}))
        for line in lines:
            say(json.dumps(act(WORDS, emulator, line)))
        server.shutdown()
