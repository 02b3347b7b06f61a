"""Poses and regions as the text of a port: `xyz: 2.9 0 0.85; rpy_deg: 180 0 0`."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pinocchio as pin
from pinocchio import SE3

from behaviours.named import BasePose, Posture, Region, ToolPose
from trees.language.value_types import Named


def place_text(place: Named) -> str:
    """A pose or region as text, with the keys of a task file."""
    return "; ".join(f"{key}: {_numbers(values)}" for key, values in _fields(place).items())


def read_place_text(text: str) -> dict[str, list[str]] | None:
    """The keys of a place and their numbers, as written; None if the text is none."""
    fields = {}
    for part in text.split(";"):
        key, colon, numbers = part.partition(":")
        if not colon:
            return None
        fields[key.strip()] = numbers.split()
    return fields


def _fields(place: Named) -> dict[str, npt.NDArray[np.float64]]:
    if isinstance(place, ToolPose):
        turn = np.rad2deg(pin.rpy.matrixToRpy(place.wTe.rotation))
        return {"xyz": place.wTe.translation, "rpy_deg": turn}
    if isinstance(place, BasePose):
        return {"base": place.wTb.translation[:2], "heading_deg": _yaw_deg(place.wTb)}
    if isinstance(place, Posture):
        return {"joints_deg": np.rad2deg(place.q)}
    assert isinstance(place, Region)
    yaw = _yaw_deg(place.wTr)
    turned = {} if not yaw[0] else {"yaw_deg": yaw}
    return {"centre": place.wTr.translation, "size": place.size, **turned}


def _yaw_deg(pose: SE3) -> npt.NDArray[np.float64]:
    return np.rad2deg([np.arctan2(pose.rotation[1, 0], pose.rotation[0, 0])])


def _numbers(values: npt.NDArray[np.float64]) -> str:
    # Twelve digits bring back what a person wrote, in spite of the way through radians.
    return " ".join(f"{value + 0.0:.12g}" for value in np.round(values, 10))
