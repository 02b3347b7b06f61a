"""Poses and regions as the text of a port: `xyz: 2.9 0 0.85; rpy_deg: 180 0 0`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from pinocchio import SE3

from behaviours import BasePose, Posture, Region, ToolPose
from trees.language import NamedValue


def pose_text(pose: NamedValue) -> str:
    """A pose or region as text, with the keys of a task file."""
    return "; ".join(f"{key}: {_numbers(values)}" for key, values in _fields(pose).items())


def _fields(pose: NamedValue) -> dict[str, npt.NDArray[np.float64]]:
    if isinstance(pose, ToolPose):
        turn = np.rad2deg(pin.rpy.matrixToRpy(pose.wTe.rotation))
        return {"xyz": pose.wTe.translation, "rpy_deg": turn}
    if isinstance(pose, BasePose):
        return {"base": pose.wTb.translation[:2], "heading_deg": _yaw_deg(pose.wTb)}
    if isinstance(pose, Posture):
        return {"joints_deg": np.rad2deg(pose.q)}
    assert isinstance(pose, Region)
    yaw = _yaw_deg(pose.wTr)
    turned = {} if not yaw[0] else {"yaw_deg": yaw}
    return {"centre": pose.wTr.translation, "size": pose.size, **turned}


def _yaw_deg(pose: SE3) -> npt.NDArray[np.float64]:
    return np.rad2deg([np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0])])


def _numbers(values: npt.NDArray[np.float64]) -> str:
    # Twelve digits give what a person wrote, in spite of the way through radians.
    return " ".join(f"{value + 0.0:.12g}" for value in np.round(values, 10))
