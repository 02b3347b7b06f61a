"""Emulated base, arm, hand and camera over one simulated world."""

import json
import subprocess
import threading
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from math import radians
from typing import Any, Self

from config import UserError
from drivers.omron import OmronOptions, Site
from drivers.panda import PandaOptions
from drivers.realsense import RealSenseOptions
from extensions.emulators import omron, panda, realsense
from extensions.emulators.common import Reported, chosen, start_module
from extensions.emulators.frankie.emulated_world import EmulatedWorld
from extensions.emulators.omron import OmronEmulator, Options, Teleop
from extensions.emulators.panda import ArmLink
from extensions.emulators.realsense import Options as CameraOptions
from extensions.emulators.realsense import RealSenseEmulator, Shot
from robots import load_real_robot

_TIMEOUT = 0.14  # timeout of the base without commands [s]
_TABLES: dict[str, Mapping[str, Reported]] = {
    part.__name__: part.AS_REPORTED for part in (omron, panda, realsense)
}
AS_REPORTED: Mapping[str, Reported] = {
    name: one for table in _TABLES.values() for name, one in table.items()
}
"""Reported behaviours of all parts."""


class FrankieEmulator:
    """The emulated parts of a robot file over one world; use it in a `with` statement."""

    def __init__(
        self,
        robot: str,
        *,
        world: str,
        scene: str,
        seed: int,
        localisation: str = "exact",
        as_reported: Sequence[str] = (),
    ) -> None:
        ways = chosen(as_reported, AS_REPORTED, "robot")
        of_base, self._of_arm, of_camera = (
            sorted(ways & table.keys()) for table in _TABLES.values()
        )
        real = load_real_robot(robot)
        if real is None or real.hardware.emulated is None:
            raise UserError(f"{robot}: `hardware: {{emulated: PORT}}` is missing")
        base, arm, eye = real.hardware.base, real.hardware.arm, real.hardware.camera
        if not (
            isinstance(base, OmronOptions)
            and isinstance(arm, PandaOptions)
            and isinstance(eye, RealSenseOptions)
        ):
            raise UserError(f"{robot}: only omron, panda and realsense have emulators")
        arcl = base.arcl
        self.robot, self._arm_at, self._link = real.body, arm.address, ArmLink()
        self.address = base.address, real.hardware.emulated  # of the console
        self.world = EmulatedWorld(self.robot, world, scene, seed, self._link, localisation)
        self.world.on_bump = self._bump
        options = Options(
            host=base.address,
            port=base.port,
            arcl_port=arcl.port if arcl else 7171,
            users={base.user: (base.password, Options().users["frankie"][1])},
            arcl_password=arcl.password if arcl else "",
            teleop=_teleop(base.site),
        )
        self.base = OmronEmulator(options, self.world, as_reported=of_base)
        camera = self.world.body.description.camera
        camera_options = CameraOptions(
            host=base.address,
            port=real.hardware.emulated + 1,
            rate=eye.rate,
            intrinsics=camera.intrinsics,
            baseline=camera.baseline,
            seed=seed,
        )
        self.camera = RealSenseEmulator(self._shoot, camera_options, as_reported=of_camera)
        self._arm: subprocess.Popen[str] | None = None
        self._asking = threading.Lock()
        self._shots = 0

    def __enter__(self) -> Self:
        """Start all parts."""
        arguments = [self._arm_at, "5", str(self._link.memory), ",".join(self._of_arm)]
        self._arm = start_module(
            "extensions.emulators.panda", *filter(None, arguments), memory=(self._link.memory,)
        )
        assert self._arm.stdout is not None
        if not self._arm.stdout.readline():
            self._end_arm()
            raise UserError(f"no arm can be emulated at {self._arm_at}: its ports are taken")
        with ExitStack() as undo:
            undo.callback(self._end_arm)
            self.world.start()
            undo.callback(self.world.close)
            undo.enter_context(self.base)
            undo.enter_context(self.camera)
            self._undo = undo.pop_all()
        return self

    def __exit__(self, *_: object) -> None:
        self._undo.close()

    def do_to_arm(self, words: str) -> dict[str, Any]:
        """Do one command of the arm's console; its answer."""
        with self._asking:
            if self._arm is None or self._arm.poll() is not None:
                return {"error": "the emulated arm has ended"}
            assert self._arm.stdin is not None
            assert self._arm.stdout is not None
            self._arm.stdin.write(words + "\n")
            self._arm.stdin.flush()
            answer: dict[str, Any] = json.loads(self._arm.stdout.readline() or "{}")
            return answer

    def blind(self, seconds: float) -> None:
        """Unplug the camera for a time [s]."""
        self.camera.unplug()
        timer = threading.Timer(seconds, self.camera.plug_in)
        timer.daemon = True
        timer.start()

    def _bump(self) -> None:
        with self.base.held() as base:
            base.bump()

    def _shoot(self) -> Shot:
        self._shots += 1
        return self.world.capture(self._shots)

    def _end_arm(self) -> None:
        if self._arm is not None:
            for stream in (self._arm.stdin, self._arm.stdout, self._arm.stderr):
                if stream is not None:
                    stream.close()
            self._arm.terminate()
            self._arm.wait()


def _teleop(site: Site) -> Teleop:
    """Setup of the emulated base as its file says."""
    values = site.values
    return Teleop(
        timeout=_TIMEOUT,
        forwards=site.forward,
        backwards=site.reverse,
        turn_at_rest=radians(site.turn_deg),
        turn_forwards=radians(values["turn_at_forward_deg"]),
        turn_backwards=radians(values["turn_at_reverse_deg"]),
        dead_translation=site.dead_translation,
        dead_rotation=site.dead_rotation,
    )
