"""Errors of a simulated robot about where it is: those of a run, and their process.

Odometry integrates the true motion with factors that wander (`slip`), so it is smooth and drifts.
The error of the localised pose wanders by one of two processes with the same deviation and the same
correlation time T; a relocalisation adds a step to it:

- `gauss_markov`, of first order: e(t + dt) = a e(t) + sqrt(1 - a^2) n, with a = exp(-dt / T) and n
  of the stated deviation.
- `bounded_walk`: a random walk that no step leads out of its bounds +-B, and white noise in each
  reading. The walk is uniform in the end; T = 8 B^2 / (pi^2 s^2) if its variance grows by s^2 a
  second (the slowest mode of diffusion between walls).
"""

from __future__ import annotations

from dataclasses import replace
from math import cos, exp, hypot, inf, pi, radians, sin, sqrt

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from hw.sim.levels import Localisation, Misplacement
from hw.state import Array, LocalisedPose
from robots import RobotDescription

_STREAM = 2  # tells the errors of localisation from the noise of sensors with the same seed


def made_wrong(
    description: RobotDescription, level: Localisation, seed: int
) -> tuple[RobotDescription, LocalisationProcess, float]:
    """The robot as it truly is, what its base tells, and measured by true depth."""
    rng = np.random.default_rng((seed, 0, _STREAM))
    if level.exact:
        return description, LocalisationProcess(level, rng), 1.0
    hand_eye, arm_mount = (_misplacement(one, rng) for one in (level.hand_eye, level.arm_mount))
    scale = 1.0 + level.depth_scale * float(rng.choice((-1.0, 1.0)))
    camera = replace(description.camera, eTc=description.camera.eTc * hand_eye)
    true = replace(description, bTa=description.bTa * arm_mount, camera=camera)
    return true, LocalisationProcess(level, rng), scale


def _misplacement(size: Misplacement, rng: np.random.Generator) -> SE3:
    offset, axis = (one / np.linalg.norm(one) for one in rng.standard_normal((2, 3)))
    return SE3(pin.exp3(radians(size.angle_deg) * axis), size.offset * offset)


GRID = 0.01  # step of the process, whenever it is read [s]
LOCALISED_EVERY = 10  # steps from one localised pose to the next: 10 Hz
_WHITE = 0.3  # deviation of the noise of a reading, as a share of all of it, for `bounded_walk`
_ROUNDING = 1e-6  # of stamps, which are sums of periods [s]


class LocalisationProcess:
    """What odometry and localisation tell of a base whose true pose is known.

    All draws and sums happen on a fixed grid of time that begins with the first reading, so how
    often it is read changes nothing. An exact level draws nothing.
    """

    def __init__(self, level: Localisation, rng: np.random.Generator) -> None:
        self._level, self._exact, self._rng = level, level.exact, rng
        pose, odometry = level.localisation, level.odometry
        turn, drift = radians(pose.sigma_deg), radians(odometry.drift_deg)
        self._sigma = np.array(
            [pose.sigma, pose.sigma, turn, odometry.slip, odometry.turn_slip, drift]
        )
        self._kept = exp(-GRID / pose.time_constant)
        self._noise = sqrt(1.0 - self._kept**2) * self._sigma
        self._white, self._bound = np.zeros(3), np.full(6, inf)
        if pose.process == "bounded_walk":
            self._white = _WHITE * self._sigma[:3]
            self._kept, self._bound = 1.0, sqrt(3.0 * (1.0 - _WHITE**2)) * self._sigma
            self._noise = self._bound * sqrt(8.0 * GRID / pose.time_constant) / pi
        self._covariance = np.diag(self._sigma[:3] ** 2)
        self._step, self._outage_end = -1, 0
        self._errors = np.zeros(6)
        self._start = self._stamp = 0.0
        self._wTb = self._grid_wTb = self._grid_oTb = SE3.Identity()
        self._localised: LocalisedPose | None = None

    def read(self, stamp: float, wTb: SE3) -> tuple[SE3, LocalisedPose | None]:
        """Pose in odometry, exact at first, and localised, None in an outage, at a stamp [s]."""
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
        self._grid_oTb, self._grid_wTb = self._moved(wTb), wTb
        self._step += 1
        self._errors = self._kept * self._errors + self._noise * self._rng.standard_normal(6)
        jump, direction, outage = self._rng.random(3).tolist()
        steps, outages = self._level.steps, self._level.outages
        if steps is not None and jump < GRID / steps.interval:
            angle = 2.0 * pi * direction
            self._errors[:2] += steps.size * np.array([cos(angle), sin(angle)])
        self._errors = np.minimum(np.maximum(self._errors, -self._bound), self._bound)
        if outages is not None and outage < GRID / outages.interval:
            self._outage_end = self._step + round(outages.duration / GRID)
        if self._step < self._outage_end:
            self._localised = None
        elif self._step % LOCALISED_EVERY == 0:
            self._localise()

    def _localise(self) -> None:
        errors = self._errors[:3]
        if self._white.any():
            errors = errors + self._white * self._rng.standard_normal(3)
        x, y, turn = errors.tolist()
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
