"""Notes of a run, as JSON lines: what its readings refer to by number, and how they end.

Numbers of arrays are there bit for bit: float64, compressed, in base64.
"""

import json
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from typing import Any, TypeAlias
from zlib import compress, decompress

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from hw import Fault, FaultKind, LaserScan, LocalisedPose

_Noted: TypeAlias = tuple[Fault, ...] | LocalisedPose | LaserScan

_FAST = 1


@dataclass(frozen=True, kw_only=True)
class RunNotes:
    """What the notes of a run say."""

    noted: Mapping[tuple[str, int], _Noted]  # by field of the readings, and number
    attended: bool  # whether somebody could acknowledge an emergency stop
    end: str  # how the readings end; empty if they were cut off


def note(field: str, number: int, noted: _Noted) -> dict[str, object]:
    """The note of what a number in a field of the readings stands for."""
    content: object
    match noted:
        case LocalisedPose():
            content = {
                "stamp": noted.stamp,
                "mTb": _packed(noted.mTb.homogeneous[:3]),
                "covariance": _packed(noted.covariance),
                "source": noted.source,
            }
        case LaserScan():
            content = {
                "stamp": noted.stamp,
                "oTb": _packed(noted.oTb.homogeneous[:3]),
                "ranges": _packed(noted.ranges),
                "points": _packed(noted.points),
            }
        case faults:
            content = [asdict(fault) | {"kind": fault.kind.name} for fault in faults]
    return {"number": number, field: content}


def read_notes(text: str) -> RunNotes:
    """The notes of a run; raises ValueError, LookupError or TypeError for anything else."""
    notes = list[dict[str, Any]]()
    for line in text.split("\n"):
        with suppress(json.JSONDecodeError):  # of one that was cut
            notes.append(json.loads(line))
    if bool(text.strip()) > bool(notes) or not all(
        {"number", "attended", "end"} & one.keys() for one in notes
    ):
        raise ValueError("no note of a run")
    noted: dict[tuple[str, int], _Noted] = {}
    for one in notes:
        if "number" in one:
            number = int(one.pop("number"))
            ((field, content),) = one.items()
            noted[field, number] = NOTED[field](content)
    last = {key: value for one in notes for key, value in one.items()}
    return RunNotes(
        noted=noted, attended=bool(last.get("attended", True)), end=str(last.get("end", ""))
    )


def _faults(content: Any) -> tuple[Fault, ...]:
    return tuple(replace(Fault(**one), kind=FaultKind[one["kind"]]) for one in content)


def _localised(content: Any) -> LocalisedPose:
    return LocalisedPose(
        stamp=float(content["stamp"]),
        mTb=_pose(content["mTb"]),
        covariance=_unpacked(content["covariance"], (3, 3)),
        source=str(content.get("source", LocalisedPose.source)),
    )


def _scan(content: Any) -> LaserScan:
    return LaserScan(
        stamp=float(content["stamp"]),
        oTb=_pose(content["oTb"]),
        ranges=_unpacked(content["ranges"], (-1,)),
        points=_unpacked(content["points"], (-1, 3)),
    )


NOTED: Mapping[str, Callable[[Any], _Noted]] = {
    "faults": _faults,
    "localised": _localised,
    "scan": _scan,
}
"""How each field of the readings that has notes is read from one."""


def _packed(array: Array) -> str:
    return b64encode(compress(np.ascontiguousarray(array, float).tobytes(), _FAST)).decode()


def _unpacked(text: str, shape: tuple[int, ...]) -> Array:
    return np.frombuffer(decompress(b64decode(text)), float).reshape(shape).copy()


def _pose(text: str) -> SE3:
    rows = _unpacked(text, (3, 4))
    return SE3(rows[:, :3].copy(), rows[:, 3].copy())
