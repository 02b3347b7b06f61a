"""The world `emulated`: the emulators of a robot file, started when they are not running."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import closing, contextmanager

from config import UserError
from extensions.emulators.common import start_module
from extensions.emulators.frankie import EmulatorLink, RemoteTruth, SilentEmulatorError
from hw import DEFAULT_LEVEL, Backend, HardwareError, Truth, WorldOptions
from hw.hardware import open_parts
from hw.sim import load_localisation, load_scene
from robots import RealRobot, load_real_robot

_PATIENCE = 30.0  # timeout of starting emulators [s]


class OtherWorldError(UserError):
    """The running emulators have another world."""


class EmulatedWorld:
    """Opens the emulated robot of a file by its real drivers."""

    def __call__(self, robot: str, options: WorldOptions) -> Backend:
        """The robot, with its emulators.

        UserError: it is emulated in another world. HardwareError: the emulators do not start.
        """
        real = load_real_robot(robot)
        assert real is not None
        wanted = (
            options.name,
            options.scene,
            options.seed,
            options.localisation or DEFAULT_LEVEL,
        )

        @contextmanager
        def surroundings() -> Iterator[Truth]:
            with closing(Emulation(real, *wanted)) as emulation:
                _check_world(emulation, wanted)
                yield emulation.truth

        return open_parts(real, options, surroundings(), "emulated")

    @contextmanager
    def running(self, real: RealRobot) -> Iterator[None]:
        """Run the emulators of a robot."""
        with closing(Emulation(real, "kinematic", "single", 0)):
            yield


emulated = EmulatedWorld()


def _check_world(emulation: Emulation, wanted: tuple[str, str, int, str]) -> None:
    truth = emulation.truth
    world, scene, seed, level = there = truth.world, truth.scene, truth.seed, truth.localisation
    if there != wanted:
        raise OtherWorldError(
            f"emulators run with --world {world} --scene {scene} --seed {seed} "
            f"--localisation {level}: say the same, or end them"
        )


class Emulation:
    """The emulators of one robot file."""

    def __init__(
        self, real: RealRobot, world: str, scene: str, seed: int, localisation: str = "exact"
    ) -> None:
        self._real, self._wanted = real, (world, scene, str(seed), localisation)
        self._process: subprocess.Popen[str] | None = None
        try:
            self.link = link_to(real)
        except SilentEmulatorError:
            self._start()
            self.link = link_to(real)
        self.truth = RemoteTruth(self.link)

    def close(self) -> None:
        """End emulators that were started here."""
        self.truth.close()
        self.link.close()
        if self._process is not None:
            assert self._process.stdin is not None
            self._process.stdin.close()
            try:
                self._process.wait(5.0)
            except subprocess.TimeoutExpired:
                self._process.kill()
            self._process = None

    def _start(self) -> None:
        _, scene, seed, localisation = self._wanted
        load_scene(scene, int(seed))  # reports errors of the scene
        load_localisation(localisation)  # and of the level
        self._process = process = start_module(
            "extensions.emulators.frankie", str(self._real.path), *self._wanted
        )
        assert process.stdout is not None
        assert process.stderr is not None
        if not process.stdout.readline():
            lines = [line for line in process.stderr.read().splitlines() if line.strip()]
            process.wait()
            reason = lines[-1] if lines else "no reason"
            raise HardwareError(f"the emulators do not begin: {reason}")


def link_to(real: RealRobot) -> EmulatorLink:
    """A connection to the emulators of a robot file; SilentEmulatorError: they do not run."""
    assert real.hardware.emulated is not None
    return EmulatorLink(getattr(real.hardware.base, "address", ""), real.hardware.emulated)
