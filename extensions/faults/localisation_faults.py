"""Faults of the localisation of the base: it jumps, or drifts."""

from dataclasses import replace
from math import cos, pi, radians, sin

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from extensions.faults.effects import Effect, Injectable, Site
from hw import DepthFrame, LocalisedPose, RobotState

_JUMP, _JUMP_ANGLE = 0.2, radians(15.0)  # [m, rad]
_DRIFT = 0.03  # share of the driven distance


class _Displaced(Effect):
    """The localised pose is wrong; without odometry so are the camera poses, made from it."""

    _offset = SE3.Identity()  # wrong pose times the inverse of the true one, on the map
    _has_odometry = False
    _told: tuple[LocalisedPose, LocalisedPose] | None = None  # the newest, and what became of it

    def reading(self, state: RobotState) -> RobotState:
        localised = state.localised
        if localised is None:
            oTb = state.oTb if self._has_odometry else self._offset * state.oTb
            return replace(state, oTb=oTb)
        self._has_odometry = True
        if self._told is None or self._told[0] is not localised:
            self._told = localised, replace(localised, mTb=self._offset * localised.mTb)
        return replace(state, localised=self._told[1])

    def frame(self, frame: DepthFrame | None) -> DepthFrame | None:
        if frame is None or self._has_odometry:
            return frame
        return replace(frame, oTc=self._offset * frame.oTc)


def _pose(state: RobotState) -> SE3:
    return state.oTb if state.localised is None else state.localised.mTb


class _LocalisationJump(_Displaced):
    def begin(self, site: Site) -> None:
        super().begin(site)
        towards = site.rng.uniform(-pi, pi)
        true = _pose(site.state)
        jump = _JUMP * np.array([cos(towards), sin(towards), 0.0])
        turn = pin.rpy.rpyToMatrix(0.0, 0.0, _JUMP_ANGLE * float(site.rng.choice((-1.0, 1.0))))
        wrong = SE3(turn @ true.rotation, true.translation + jump)
        self._offset = wrong * true.inverse()


class _LocalisationDrift(_Displaced):
    _before: tuple[SE3, SE3] | None = None

    def reading(self, state: RobotState) -> RobotState:
        here = _pose(state)
        true, drifted = self._before or (here, here)
        step = true.inverse() * here
        drifted = drifted * SE3(step.rotation, (1.0 + _DRIFT) * step.translation)
        self._before, self._offset = (here, drifted), drifted * here.inverse()
        return super().reading(state)


LOCALISATION_FAULTS = (
    Injectable("localisation jump", _LocalisationJump, "the base believes to be 0.2 m and 15° off"),
    Injectable(
        "localisation drift", _LocalisationDrift, "the base adds 3 % to the distance that it drives"
    ),
)
