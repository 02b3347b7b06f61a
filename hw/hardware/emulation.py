"""The emulators of an emulated robot, started when they are not running."""

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager

from hw.emulators.common import start_module
from hw.emulators.frankie import EmulatorLink, RemoteTruth, SilentEmulatorError
from hw.robot import HardwareError
from hw.sim import load_localisation, load_scene
from robots import RealRobot

_PATIENCE = 30.0  # timeout of starting emulators [s]


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
            "hw.emulators.frankie", str(self._real.path), *self._wanted
        )
        assert process.stdout is not None
        assert process.stderr is not None
        if not process.stdout.readline():
            lines = [line for line in process.stderr.read().splitlines() if line.strip()]
            process.wait()
            reason = lines[-1] if lines else "no reason"
            raise HardwareError(f"the emulators do not begin: {reason}")


@contextmanager
def emulating(real: RealRobot | None) -> Iterator[None]:
    """Run the emulators of a robot, if it is emulated."""
    if real is None or real.hardware.emulated is None:
        yield
        return
    emulation = Emulation(real, "kinematic", "single", 0)
    try:
        yield
    finally:
        emulation.close()


def link_to(real: RealRobot) -> EmulatorLink:
    """A connection to the emulators of a robot file; SilentEmulatorError: they do not run."""
    assert real.hardware.emulated is not None
    return EmulatorLink(getattr(real.hardware.base, "address", ""), real.hardware.emulated)
