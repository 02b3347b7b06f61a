"""Simulated rigs to be calibrated: an arm with a camera, and a base with both."""

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from scipy.optimize import least_squares

from config.poses import OdometryPose
from controller import RobotModel
from lab.calibration.board import Array, Board, Grey
from lab.calibration.photograph import photograph
from lab.calibration.postures import aTe_of
from robots import Intrinsics, RobotDescription

_PIXELS = 60  # per square in the picture of the board
_GROUND = 0.4  # brightness around the board, between ink and paper


@dataclass(frozen=True, kw_only=True)
class Look:
    """Appearance of the board in the image."""

    blur: float = 0.7  # standard deviation of the lens' blur [px]
    noise: float = 4.0  # standard deviation of the noise, of 255
    black: float = 40.0  # brightness of the ink, of 255
    white: float = 190.0  # brightness of the paper, of 255
    shade: float = 0.25  # by which the light falls off from one edge of the image to the other


def render(
    board: Board, cTk: SE3, camera: Intrinsics, look: Look, rng: np.random.Generator
) -> Grey:
    """(H, W) brightness of an image of the board at cTk on a grey ground, with blur and noise."""
    printed = board.picture(_PIXELS).astype(np.float32) / 255.0
    paper = np.pad(printed, _PIXELS // 2, constant_values=1.0)
    edge = -0.5 * board.square
    return photograph(
        np.float32(look.black) + np.float32(look.white - look.black) * paper,
        board.square / _PIXELS,
        cTk * SE3(np.eye(3), np.array([edge, edge, 0.0])),
        camera,
        rng,
        ground=look.black + (look.white - look.black) * _GROUND,
        blur=look.blur,
        noise=look.noise,
        shade=look.shade,
    )


@dataclass(frozen=True, kw_only=True)
class Noise:
    """Errors of a simulated rig."""

    look: Look = field(default_factory=Look)
    joints: float = 1e-4  # standard deviation of a joint position [rad]
    place: float = 5e-4  # standard deviation of the base's place along x and along y [m]
    heading: float = np.deg2rad(0.03)  # standard deviation of the base's heading [rad]


class SimulatedArm:
    """An arm over a board, with a camera mount that differs from the robot file."""

    def __init__(
        self,
        description: RobotDescription,
        board: Board,
        noise: Noise,
        rng: np.random.Generator,
    ) -> None:
        self._board, self._noise, self._rng = board, noise, rng
        self._camera = description.camera.intrinsics
        self._model = RobotModel(description)
        self.eTc = _beside(description.camera.eTc, (0.01, 0.03), rng)
        self._q = description.arm.ready.copy()
        turn = pin.utils.rotate("z", rng.uniform(-np.pi, np.pi)) @ pin.utils.rotate("x", 0.05)
        cTk = SE3(turn, np.array([0.0, 0.0, rng.uniform(0.38, 0.45)]) - turn @ board.centre)
        self.aTk = aTe_of(self._model, self._q) * self.eTc * cTk

    def q(self) -> Array:
        """With noise."""
        noisy: Array = self._q + self._noise.joints * self._rng.standard_normal(7)
        return noisy

    def move_to(self, q: Array) -> None:
        """At once."""
        self._q = q.copy()

    def image(self) -> Grey:
        """With noise and blur."""
        cTk = (aTe_of(self._model, self._q) * self.eTc).actInv(self.aTk)
        return render(self._board, cTk, self._camera, self._noise.look, self._rng)


class SimulatedBase:
    """A base at a board on the floor, with an arm's foot that differs from the robot file.

    Its camera mount is right; `places` is their number.
    """

    def __init__(
        self,
        description: RobotDescription,
        board: Board,
        noise: Noise,
        rng: np.random.Generator,
        places: int,
    ) -> None:
        self._description, self._board = description, board
        self._noise, self._rng = noise, rng
        self._remaining = places
        self._model = RobotModel(description)
        self.bTa = _beside(description.bTa, (0.01, 0.02), rng)
        self._q = _looking_down(description, self._model)
        self._oTb = SE3.Identity()

    def next_place(self) -> bool:
        """Somewhere around the board, which stays in the middle of the map."""
        if self._remaining == 0:
            return False
        self._remaining -= 1
        rng, camera = self._rng, self._description.camera
        seen = camera.intrinsics
        u, v = rng.uniform(0.2, 0.8, 2) * (seen.width, seen.height)
        bTc = self._model.bTe(self._q) * camera.eTc
        ray = bTc.rotation @ [(u - seen.cx) / seen.fx, (v - seen.cy) / seen.fy, 1.0]
        centre = bTc.translation[:2] - bTc.translation[2] / ray[2] * ray[:2]
        turn = pin.utils.rotate("z", rng.uniform(-np.pi, np.pi))
        self._oTb = SE3(turn, -turn @ np.array([*centre, 0.0]))
        return True

    def oTb(self) -> OdometryPose:
        """With noise."""
        noise, rng = self._noise, self._rng
        shift = np.array([*rng.normal(0.0, noise.place, 2), 0.0])
        turn = pin.utils.rotate("z", rng.normal(0.0, noise.heading))
        oTb: OdometryPose = SE3(self._oTb.rotation @ turn, self._oTb.translation + shift)
        return oTb

    def q(self) -> Array:
        """With noise."""
        noisy: Array = self._q + self._noise.joints * self._rng.standard_normal(7)
        return noisy

    def image(self) -> Grey:
        """With noise and blur."""
        description = self._description
        face_up = pin.utils.rotate("x", np.pi)
        oTk = SE3(face_up, -face_up @ self._board.centre)
        oTc = self._oTb * self.bTa * aTe_of(self._model, self._q) * description.camera.eTc
        camera = description.camera.intrinsics
        return render(self._board, oTc.actInv(oTk), camera, self._noise.look, self._rng)


def _beside(pose: SE3, offset: tuple[float, float], rng: np.random.Generator) -> SE3:
    moved = SE3(pin.exp3(rng.normal(0.0, offset[1], 3)), rng.normal(0.0, offset[0], 3))
    return pose * moved


def _looking_down(description: RobotDescription, model: RobotModel) -> Array:
    """(j,) joint positions with the camera over the floor before the base."""
    limits, ready, eTc = description.limits, description.arm.ready, description.camera.eTc
    rotation = (model.bTe(ready) * eTc).rotation
    goal = SE3(rotation, np.array([description.base.size[0] / 2.0 + 0.2, 0.0, 0.38]))

    def miss(q: Array) -> Array:
        apart = goal.actInv(model.bTe(q) * eTc)
        return np.array([*apart.translation, *pin.log3(apart.rotation)])

    found: Array = least_squares(miss, ready, bounds=(limits.q_min, limits.q_max)).x
    return found
