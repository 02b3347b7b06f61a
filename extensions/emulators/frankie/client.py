"""Client of an emulated Frankie: commands to it, and the ground truth of its world."""

import json
import socket
import threading
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from pinocchio import SE3, XYZQUATToSE3

from config.planar import Pose2D
from controller import Obstacle, se3_of
from hw import HardwareError, Touch, stopwatch
from hw.sim import SimObject, load_localisation, load_scene

_PATIENCE = 3.0  # timeout [s]
_LOOK = 0.1  # polling interval of the world [s]


class SilentEmulatorError(HardwareError):
    """The emulator does not run, or does not answer."""


class EmulatorLink:
    """One connection to an emulated Frankie; may be used by several threads."""

    def __init__(self, address: str, port: int) -> None:
        self._lock = threading.Lock()
        try:
            self._socket = socket.create_connection((address, port), _PATIENCE)
        except OSError as error:
            raise SilentEmulatorError(f"no robot is emulated at port {port}: {error}") from None
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._file = self._socket.makefile("rwb")

    def do(self, words: str) -> dict[str, Any]:
        """Do one command; its answer. SilentEmulatorError: there is none; ValueError: wrong."""
        try:
            with self._lock:
                self._file.write(words.encode() + b"\n")
                self._file.flush()
                line = self._file.readline()
        except (OSError, ValueError) as error:
            raise SilentEmulatorError(f"the emulator does not answer: {error}") from None
        if not line:
            raise SilentEmulatorError("the emulator has ended")
        answer: dict[str, Any] = json.loads(line)
        if "error" in answer:
            raise ValueError(answer["error"])
        return answer

    def close(self) -> None:
        """Disconnect."""
        with suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


class RemoteTruth:
    """Ground truth of an emulated Frankie, for scoring and drawing."""

    def __init__(self, link: EmulatorLink) -> None:
        self._link = link
        answer = link.do("tell")
        self.scene, self.seed = str(answer["scene"]), int(answer["seed"])
        self.world, self.localisation = str(answer["world"]), str(answer["localisation"])
        moved = load_localisation(self.localisation).moved
        self._world = world = load_scene(self.scene, self.seed, moved=moved)
        self.fixtures, self.mapped = world.fixtures, world.mapped
        self.objects: Sequence[SimObject] = world.objects  # with their latest known poses
        self.walkers: Sequence[Any] = world.walkers
        self._supports: dict[str, str] = {}
        self._over = threading.Event()
        self._update(answer)
        self._thread = threading.Thread(target=self._follow, name="truth", daemon=True)
        self._thread.start()

    @property
    def touches(self) -> Sequence[Touch]:
        """Contacts of the robot so far."""
        self._look()
        return self._touches

    @property
    def base(self) -> SE3:
        """Where the base truly is."""
        self._look()
        return se3_of(Pose2D(*self._base))

    def moving(self) -> Sequence[Obstacle]:
        """The walkers as tracked obstacles."""
        now = self._now + stopwatch() - self._at
        for walker in self._world.walkers:
            walker.move_to(now)
        return self._world.moving()

    def supports(self) -> Mapping[str, str]:
        """Name of the support of each object."""
        with suppress(SilentEmulatorError):
            self._supports = self._link.do("supports")["supports"]
        return self._supports

    def put(self, name: str, wTs: SE3) -> None:
        """Put an object at a pose; it falls onto its support."""
        x, y, z = wTs.translation
        self._link.do(f"put {name} {x} {y} {z}")

    def give(self, name: str) -> None:
        """A person holds an object between the fingers, until they have it."""
        self._link.do(f"give {name}")

    def close(self) -> None:
        """Stop polling."""
        self._over.set()
        self._thread.join()

    def _follow(self) -> None:
        while not self._over.wait(_LOOK):
            self._look()

    def _look(self) -> None:
        with suppress(SilentEmulatorError):
            self._update(self._link.do("tell"))

    def _update(self, answer: dict[str, Any]) -> None:
        for obj in self._world.objects:
            obj.pose = XYZQUATToSE3(np.array(answer["poses"][obj.name]))
        self._now, self._at = answer["now"], answer["stamp"]
        self._base = answer["base"]
        self._touches = [Touch(**one) for one in answer["touches"]]
