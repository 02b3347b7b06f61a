"""Calibrations recover transforms that are known, and refuse views that do not determine them."""

import numpy as np
import pytest
from pinocchio import SE3

from controller import robot_model
from lab.calibration import (
    Board,
    CalibrationError,
    Noise,
    SimulatedArm,
    SimulatedBase,
    calibrate_base_arm,
    calibrate_hand_eye,
    difference,
)
from robots import load_robot

FRANKIE, BOARD = load_robot("frankie"), Board()


def hand_eye(seed: int, views: int = 16, board: Board = BOARD, rig=SimulatedArm):
    rng = np.random.default_rng(seed)
    arm = rig(FRANKIE, BOARD, Noise(), rng)
    return arm, calibrate_hand_eye(arm, FRANKIE, board, views, rng)


def base_arm(seed: int, views: int = 16, thickness: float = 0.0, rig=SimulatedBase, **noise):
    base = rig(FRANKIE, BOARD, Noise(**noise), np.random.default_rng(seed), views)
    return base, calibrate_base_arm(base, FRANKIE, BOARD, thickness)


class Watched(SimulatedArm):
    lowest = np.inf

    def move_to(self, q):
        super().move_to(q)
        limits, model = FRANKIE.limits, robot_model("frankie")
        assert ((q > limits.q_min) & (q < limits.q_max)).all()
        tip = FRANKIE.bTa.actInv(model.bTe(q)).act(np.array([0.0, 0.0, FRANKIE.gripper.tip]))
        self.lowest = min(self.lowest, -self.aTk.actInv(tip)[2])


def test_hand_eye_recovers_the_mount_of_the_camera_and_stays_above_the_board():
    arm, found = hand_eye(seed=3, views=24, rig=Watched)
    wrong = difference(found.transform, arm.eTc)
    assert difference(FRANKIE.camera.eTc, arm.eTc).mm > 3.0  # it had something to find
    assert wrong.mm < 0.5
    assert wrong.deg < 0.05
    assert found.shortcomings() == []
    assert found.residual < 0.3
    assert found.check.mm < 1.5
    assert wrong.mm < 4.0 * found.uncertainty.mm < 4.0  # the estimate is of the true size
    assert arm.lowest > 0.08  # the nominal mount, by which it was planned, is wrong by centimetres


def test_base_arm_recovers_the_foot_of_the_arm():
    base, found = base_arm(seed=1, views=30)
    wrong = difference(found.transform, base.bTa)
    assert difference(FRANKIE.bTa, base.bTa).mm > 3.0
    assert wrong.mm < 1.0
    assert wrong.deg < 0.1
    assert found.shortcomings() == []


class Bumped(SimulatedArm):
    """The board is pushed half way."""

    _moves = 0

    def move_to(self, q):
        super().move_to(q)
        self._moves += 1
        if self._moves == 10:
            self.aTk = self.aTk * SE3(np.eye(3), np.array([0.01, 0.0, 0.0]))


class Stiff(SimulatedArm):
    """Every motion ends almost where it began."""

    def move_to(self, q):
        super().move_to(FRANKIE.arm.ready + 1e-3 * (q - FRANKIE.arm.ready))


class OneAxis(SimulatedArm):
    """Only the last joint turns, which leaves the camera's place along its axis open."""

    def move_to(self, q):
        super().move_to(np.array([*FRANKIE.arm.ready[:6], q[6]]))


class Straight(SimulatedBase):
    """The base never turns."""

    def next_place(self):
        more = super().next_place()
        self._oTb = SE3(np.eye(3), self._oTb.rotation.T @ self._oTb.translation)
        return more


LARGER, LOST = Board(square=0.042, marker=0.0315), {"place": 0.03, "heading": np.deg2rad(1.0)}


@pytest.mark.parametrize(
    ("calibrate", "options", "why"),
    [
        (hand_eye, {"seed": 1, "board": LARGER}, r"residual .* --square"),
        (hand_eye, {"seed": 2, "rig": Stiff}, "uncertainty"),
        (hand_eye, {"seed": 2, "rig": OneAxis}, "uncertainty"),
        (hand_eye, {"seed": 2, "rig": Bumped}, "residual"),
        (base_arm, {"seed": 1, "rig": Straight}, "uncertainty"),
        (base_arm, {"seed": 1, **LOST}, "does the base know where it is"),
    ],
)
def test_poor_results_are_refused(calibrate, options, why):
    _, found = calibrate(**options)
    with pytest.raises(CalibrationError, match=why):
        found.require_good()


class Dark(SimulatedArm):
    """The light goes out after `last` images."""

    last, _seen = 4, 0

    def image(self):
        self._seen += 1
        return super().image() if self._seen <= self.last else np.zeros((480, 640), np.uint8)


class Blind(Dark):
    last = 0


@pytest.mark.parametrize(
    ("rig", "why"), [(Dark, "in 3 of 16 images, 10 are needed"), (Blind, "does not see the board")]
)
def test_a_board_that_is_not_seen_is_reported(rig, why):
    with pytest.raises(CalibrationError, match=why):
        hand_eye(seed=0, rig=rig)


def test_the_thickness_of_the_board_is_the_height_of_the_arm():
    _, flat = base_arm(seed=1)
    _, thick = base_arm(seed=1, thickness=0.01)
    higher = thick.transform.translation - flat.transform.translation
    assert higher[2] == pytest.approx(0.01, abs=1e-4)
