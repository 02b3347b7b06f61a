"""Errors of a simulated robot about where it is: levels, errors of a run, and their process.

Odometry integrates the true motion with factors that wander (`slip`), so it is smooth and drifts.
The localised pose has a first-order Gauss-Markov error: e(t + dt) = a e(t) + sqrt(1 - a^2) n, with
a = exp(-dt / time constant) and n of the stated deviation. A relocalisation adds a step to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import cos, exp, hypot, pi, radians, sin, sqrt
from os.path import isfile
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, TypeAlias

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from pydantic import Field

from config import ConfigError, StrictModel, read_config, suggest
from hw.state import Array, BaseState, LocalisedPose
from robots import RobotDescription

Length: TypeAlias = Annotated[float, Field(ge=0.0, le=10.0)]
Degrees: TypeAlias = Annotated[float, Field(ge=0.0, le=90.0)]
Share: TypeAlias = Annotated[float, Field(ge=0.0, le=0.5)]
Shift: TypeAlias = Annotated[float, Field(ge=-1.0, le=1.0)]
Turn: TypeAlias = Annotated[float, Field(ge=-90.0, le=90.0)]
Seconds: TypeAlias = Annotated[float, Field(ge=0.1, le=1e5)]


class PoseError(StrictModel):
    """Deviations of the localised pose."""

    sigma: Length = 0.0  # along x and along y of the map [m]
    sigma_deg: Degrees = 0.0
    time_constant: Seconds = 5.0  # in which errors are forgotten, those of odometry too [s]


class Steps(StrictModel):
    """Relocalisations: the pose jumps, and the jump is forgotten with the time constant."""

    size: Length  # [m]
    interval: Seconds  # on average [s]


class Outages(StrictModel):
    """Times without a localised pose."""

    interval: Seconds  # on average, between their beginnings [s]
    duration: Seconds  # [s]


class Odometry(StrictModel):
    """Deviations of what odometry tells of a motion."""

    slip: Share = 0.0  # of a distance, as a share of it
    turn_slip: Share = 0.0  # of an angle, as a share of it
    drift_deg: Degrees = 0.0  # turning while driving straight on [deg/m]


class Misplacement(StrictModel):
    """Error of a mount, in an unknown direction."""

    offset: Length = 0.0  # [m]
    angle_deg: Degrees = 0.0


class Localisation(StrictModel):
    """How wrong a robot is about where it is: a level."""

    localisation: PoseError = PoseError()
    steps: Steps | None = None
    outages: Outages | None = None
    odometry: Odometry = Odometry()
    hand_eye: Misplacement = Misplacement()  # of the camera on the hand
    arm_mount: Misplacement = Misplacement()  # of the arm on the base
    depth_scale: Share = 0.0  # error of all depths, as a share of them
    moved: Mapping[str, tuple[Shift, Shift, Turn]] = {}
    """Furniture that does not stand where the map has it: by x, y [m], and a turn [deg]."""

    @property
    def exact(self) -> bool:
        """Whether nothing is wrong."""
        return self == Localisation()


LEVELS: Mapping[str, Localisation] = MappingProxyType(
    {
        "exact": Localisation(),
        "good": Localisation(
            localisation=PoseError(sigma=0.02, sigma_deg=0.5),
            steps=Steps(size=0.03, interval=60.0),
            odometry=Odometry(slip=0.03, turn_slip=0.03),
            hand_eye=Misplacement(offset=0.003, angle_deg=0.5),
            depth_scale=0.005,
        ),
        "poor": Localisation(
            localisation=PoseError(sigma=0.04, sigma_deg=1.5),
            steps=Steps(size=0.08, interval=60.0),
            odometry=Odometry(slip=0.05, turn_slip=0.05),
            hand_eye=Misplacement(offset=0.005, angle_deg=1.0),
            depth_scale=0.01,
        ),
    }
)
"""The shipped levels, by name."""


def load_localisation(level: str) -> Localisation:
    """A level by its name, or from a YAML file.

    Raises:
        ConfigError: there is no such level or file, or the file says something impossible.
    """
    if level in LEVELS:
        return LEVELS[level]
    if isfile(level):
        return read_config(Path(level), Localisation)
    hint = suggest(level, LEVELS)
    raise ConfigError(f"no level of localisation is called `{level}`; {hint} (or give a file)")


_STREAM = 2
"""Tells the errors of localisation from the noise of sensors with the same seed."""


@dataclass(frozen=True, eq=False)
class FixedErrors:
    """What stays wrong during a run."""

    hand_eye: SE3  # true camera in the camera of the description
    arm_mount: SE3  # true foot of the arm in that of the description
    depth_scale: float  # measured by true depth

    def applied_to(self, believed: RobotDescription) -> RobotDescription:
        """The robot as it truly is, where the believed one is its description."""
        camera = replace(believed.camera, eTc=believed.camera.eTc * self.hand_eye)
        return replace(believed, bTa=believed.bTa * self.arm_mount, camera=camera)


def draw_fixed_errors(level: Localisation, rng: np.random.Generator) -> FixedErrors:
    """The errors of one run, of the stated sizes, in random directions."""
    return FixedErrors(
        hand_eye=_misplacement(level.hand_eye, rng),
        arm_mount=_misplacement(level.arm_mount, rng),
        depth_scale=1.0 + level.depth_scale * float(rng.choice((-1.0, 1.0))),
    )


def made_wrong(
    description: RobotDescription, level: Localisation, seed: int
) -> tuple[RobotDescription, LocalisationProcess, float]:
    """The robot as it truly is, what its base tells, and measured by true depth."""
    rng = np.random.default_rng((seed, 0, _STREAM))
    if level.exact:
        return description, LocalisationProcess(level, rng), 1.0
    errors = draw_fixed_errors(level, rng)
    return errors.applied_to(description), LocalisationProcess(level, rng), errors.depth_scale


def _misplacement(size: Misplacement, rng: np.random.Generator) -> SE3:
    offset, axis = (one / np.linalg.norm(one) for one in rng.standard_normal((2, 3)))
    return SE3(pin.exp3(radians(size.angle_deg) * axis), size.offset * offset)


GRID = 0.01  # step of the process, whenever it is read [s]
LOCALISED_EVERY = 10  # steps from one localised pose to the next: 10 Hz
_ROUNDING = 1e-6  # of stamps, which are sums of periods [s]


class LocalisationProcess:
    """What odometry and localisation tell of a base whose true pose is known.

    All draws and all sums happen on a fixed grid of time that begins with the first reading, so how
    often it is read changes nothing. An exact level draws nothing.

    Args:
        level: how wrong.
        rng: source of the errors, of this process alone.
    """

    def __init__(self, level: Localisation, rng: np.random.Generator) -> None:
        self._level, self._exact, self._rng = level, level.exact, rng
        pose, odometry = level.localisation, level.odometry
        turn, drift = radians(pose.sigma_deg), radians(odometry.drift_deg)
        self._sigma = np.array(
            [pose.sigma, pose.sigma, turn, odometry.slip, odometry.turn_slip, drift]
        )
        self._kept = exp(-GRID / pose.time_constant)
        self._covariance = np.diag(self._sigma[:3] ** 2)
        self._step, self._outage_end = -1, 0
        self._errors = np.zeros(6)
        self._start = self._stamp = 0.0
        self._wTb = self._grid_wTb = self._grid_oTb = SE3.Identity()
        self._localised: LocalisedPose | None = None

    def read(self, stamp: float, wTb: SE3) -> tuple[SE3, LocalisedPose | None]:
        """Pose in odometry, and the newest localised pose, at a time not before the last one.

        Args:
            stamp: of the reading [s].
            wTb: true pose then.

        Returns:
            oTb, the true pose at the first reading, then smooth; and the localised pose, the same
            object until there is a newer one: None during an outage, and for an exact level.
        """
        if self._exact:
            return wTb, None
        if self._step < 0:
            self._begin(stamp, wTb)
        while (time := self._start + (self._step + 1) * GRID) <= stamp + _ROUNDING:
            here = wTb
            if time < stamp - _ROUNDING:
                share = (time - self._stamp) / (stamp - self._stamp)
                here = SE3.Interpolate(self._wTb, wTb, min(max(share, 0.0), 1.0))
            self._advance(here)
        self._stamp, self._wTb = stamp, wTb
        return self._moved(wTb), self._localised

    def measured(self, true: BaseState) -> BaseState:
        """A true reading as the base measures it: `wTb` in odometry, with `localised`."""
        if self._exact:
            return true
        oTb, localised = self.read(true.stamp, true.wTb)
        return replace(true, wTb=oTb, localised=localised)

    def driven(self, twist: Array) -> Array:
        """(3,) the true twist of a base whose wheels turn for `twist` (3,), and slip."""
        if self._exact:
            return twist
        slip, turn_slip, drift = self._errors[3:].tolist()
        vx, vy, w = twist.tolist()
        vx, vy = vx / (1.0 + slip), vy / (1.0 + slip)
        return np.array([vx, vy, (w - drift * hypot(vx, vy)) / (1.0 + turn_slip)])

    def told(self, twist: Array) -> Array:
        """(3,) the twist for which the wheels turn while the base truly has `twist` (3,)."""
        return twist if self._exact else self._slipped(twist)

    def _begin(self, stamp: float, wTb: SE3) -> None:
        """At the first reading odometry is exact, and the localised pose is as wrong as ever."""
        self._errors = self._sigma * self._rng.standard_normal(6)
        self._start = self._stamp = stamp
        self._wTb = self._grid_wTb = self._grid_oTb = wTb
        self._step = 0
        self._localise()

    def _advance(self, wTb: SE3) -> None:
        """One step of the grid, to a true pose."""
        self._grid_oTb, self._grid_wTb = self._moved(wTb), wTb
        self._step += 1
        noise = self._sigma * self._rng.standard_normal(6)
        self._errors = self._kept * self._errors + sqrt(1.0 - self._kept**2) * noise
        jump, direction, outage = self._rng.random(3).tolist()
        steps, outages = self._level.steps, self._level.outages
        if steps is not None and jump < GRID / steps.interval:
            angle = 2.0 * pi * direction
            self._errors[:2] += steps.size * np.array([cos(angle), sin(angle)])
        if outages is not None and outage < GRID / outages.interval:
            self._outage_end = self._step + round(outages.duration / GRID)
        if self._step < self._outage_end:
            self._localised = None
        elif self._step % LOCALISED_EVERY == 0:
            self._localise()

    def _localise(self) -> None:
        x, y, turn = self._errors[:3].tolist()
        wrong = pin.utils.rotate("z", turn) @ self._grid_wTb.rotation
        self._localised = LocalisedPose(
            stamp=self._start + self._step * GRID,
            mTb=SE3(wrong, self._grid_wTb.translation + np.array([x, y, 0.0])),
            covariance=self._covariance,
        )

    def _moved(self, wTb: SE3) -> SE3:
        """Pose in odometry at a true pose within this step of the grid."""
        vx, vy, _, _, _, w = pin.log6(self._grid_wTb.actInv(wTb)).vector
        vx, vy, w = self._slipped(np.array([vx, vy, w]))
        return self._grid_oTb * pin.exp6(np.array([vx, vy, 0.0, 0.0, 0.0, w]))

    def _slipped(self, motion: Array) -> Array:
        """What odometry tells of a motion (3,) along x and y and about z of the base."""
        vx, vy, w = motion.tolist()
        slip, turn_slip, drift = self._errors[3:].tolist()
        along, turn = 1.0 + slip, 1.0 + turn_slip
        return np.array([along * vx, along * vy, turn * w + drift * hypot(vx, vy)])
