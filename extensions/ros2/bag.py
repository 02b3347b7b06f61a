"""A finished run as an MCAP file: the snapshots of the run, put together again from its files.

States, commands and the tree are complete. Poses, goals, paths and images are those that the
recording has.
"""

import json
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import nan
from os.path import isfile
from pathlib import Path
from typing import Any

import numpy as np
from pinocchio import SE3, Quaternion
from py_trees.common import Status

from app.core import OPTIONS, RECORDING, begun, recorded_robot, recorded_scene
from app.live import NodeStatus, PoseEstimate, ShownRun, Snapshot
from app.review import FaultEvent, NodeEvent, chunks, depth_images, read_log, read_motion, tree_of
from config import UserError
from config.planar import Pose2D, on_floor
from controller import Command, PoseGoal, RobotModel, StepReport, se3_of
from extensions.ros2.run_messages import Schemas
from hw import DepthFrame, Fault, FaultKind, RobotState
from robots import Array, Intrinsics, load_robot

_BASE, _CAMERA, _WAY = "world/robot/base", "world/camera", "world/way"
_HAND_GOAL, _BASE_GOAL = "world/ghost/hand", "world/ghost/base"
_IMAGE, _OBJECTS = "world/camera/depth", "world/objects/"
_NO_GOAL = -50.0  # a goal that is drawn lower is none [m]
_UNKNOWN = np.full((3, 3), nan)  # the covariance, which is not recorded
_PINHOLE = ("image_from_camera", "resolution")
_SOON = 0.004  # times of one tick differ by less [s]

_Change = tuple[float, str, Any]  # time [s], what it is, and its value from then on


def export_mcap(folder: Path, out: Path, schemas: Schemas = "ros2") -> None:
    """Write what a run showed into a new file, as messages.

    Raises UserError: the extra is missing, the run cannot be read, or the file cannot be written.
    """
    from extensions.ros2.foxglove import write_mcap  # an extra

    log, (states, commands) = read_log(folder), read_motion(folder)
    changes: list[_Change] = [(event.time, "event", event) for event in log.events]
    try:
        options = json.loads((folder / OPTIONS).read_text(encoding="utf-8"))
        robot = load_robot(recorded_robot(folder, options))
        sent = commands[np.searchsorted(commands[:, 0], states[:, 0] + _SOON) - 1]
        scene = recorded_scene(options, robot)
        if isfile(folder / RECORDING):
            changes += _drawn(folder / RECORDING)
    except (OSError, RuntimeError, LookupError, TypeError, ValueError) as error:
        why = " ".join(str(error).split())[:200]
        raise UserError(f"{folder}: cannot be read ({why}); name another run") from error
    changes.sort(key=lambda change: (change[0], change[1] == _IMAGE))  # an image after its pose
    tree = tree_of(log)
    turns = zip(states, sent, strict=True)
    snapshots = _snapshots(turns, changes, RobotModel(robot), len(tree), len(scene.objects))
    write_mcap(out, ShownRun(robot, tuple(tree), scene, begun(folder)), snapshots, schemas)


def _snapshots(
    turns: Iterable[tuple[Array, Array]],
    changes: Sequence[_Change],
    model: RobotModel,
    nodes: int,
    objects: int,
) -> Iterator[Snapshot]:
    """One for each reading, in order; `nodes` and `objects` are how many there are."""
    statuses, faults = (NodeStatus(Status.INVALID, ""),) * nodes, tuple[Fault, ...]()
    poses, mTo, exact = (SE3.Identity(),) * objects, SE3.Identity(), True
    now, done = dict[str, Any](), 0
    for tick, (row, command) in enumerate(turns):
        stamp, oTb, j = float(row[0]), se3_of(Pose2D(*row[1:4])), command.size - 4
        now[_IMAGE] = None
        while done < len(changes) and changes[done][0] < stamp + _SOON:
            time, name, thing = changes[done]
            done += 1
            match thing:
                case NodeEvent(node=index, status=status, message=message):
                    changed = NodeStatus(Status(status), message)
                    statuses = (*statuses[:index], changed, *statuses[index + 1 :])
                case FaultEvent(faults=texts):  # of which the log tells no kind
                    kind = FaultKind.NOT_READY
                    faults = tuple(Fault(kind=kind, text=one, clearable=False) for one in texts)
                case DepthFrame():
                    now[_IMAGE] = replace(thing, oTc=now.get(_CAMERA, thing.oTc))
                case SE3() if name.startswith(_OBJECTS):
                    number = int(name.removeprefix(_OBJECTS))
                    poses = (*poses[:number], thing, *poses[number + 1 :])[:objects]
                case _:
                    now[name] = thing
            if name == _BASE and time > stamp - _SOON:
                mTo = thing * oTb.inverse()
                exact = exact and mTo.isIdentity(1e-4)
        hand, base = _goal(now.get(_HAND_GOAL)), _goal(now.get(_BASE_GOAL))
        yield Snapshot(
            tick=tick,
            time=stamp,
            state=RobotState(
                stamp=stamp,
                oTb=oTb,
                base_twist=row[4:7],
                q=row[7 : 7 + j],
                qd=row[7 + j : 7 + 2 * j],
                gripper_width=float(row[-1]),
                gripper_moving=False,
                faults=faults,
            ),
            command=Command(base_twist=command[1:4], qd=command[4:]),
            report=StepReport(
                arrived=False,
                position_error=nan,
                orientation_error=nan,
                manipulability=nan,
                heading_error=nan,
                bTe=model.bTe(row[7 : 7 + j]),
                stance=None if base is None else Pose2D.of(base),
                way=now.get(_WAY),
            ),
            seconds=nan,
            nodes=statuses,
            goal=None if hand is None else PoseGoal(target=hand),
            estimate=None if exact else PoseEstimate(on_floor(mTo * oTb), _UNKNOWN, mTo),
            objects=poses,
            frame=now[_IMAGE],
        )


def _goal(drawn: SE3 | None) -> SE3 | None:
    return None if drawn is None or drawn.translation[2] < _NO_GOAL else drawn


def _drawn(recording: Path) -> Iterator[_Change]:
    """The poses, paths and images of a recording."""
    lens: Intrinsics | None = None
    for chunk in chunks(recording, "/world/poses", "/world/way", "/world/camera"):
        batch = chunk.to_record_batch()
        columns = {name: batch.column(name) for name in batch.schema.names}
        if "Pinhole:resolution" in columns:
            (k,), ((w, h),) = (columns[f"Pinhole:{of}"][0].as_py() for of in _PINHOLE)
            lens = Intrinsics(width=int(w), height=int(h), fx=k[0], fy=k[4], cx=k[6], cy=k[7])
        if "t" not in columns:
            continue
        times = [1e-9 * ns for ns in columns["t"].cast("int64").to_pylist()]
        if "LineStrips3D:strips" in columns:
            strips = columns["LineStrips3D:strips"].to_pylist()
            yield from ((time, _WAY, _way(one)) for time, one in zip(times, strips, strict=True))
            continue
        names = columns["Transform3D:child_frame"].flatten().to_pylist()
        turns, points = (
            columns[f"Transform3D:{of}"].flatten().flatten().to_numpy().astype(float)
            for of in ("quaternion", "translation")
        )
        for i, (time, name) in enumerate(zip(times, names, strict=True)):
            if name.startswith(_OBJECTS):
                name = name.partition("_")[0]  # their number
            elif name not in (_BASE, _CAMERA, _HAND_GOAL, _BASE_GOAL):
                continue
            turn = Quaternion(turns[4 * i : 4 * i + 4]).normalized()
            yield time, name, SE3(turn, points[3 * i : 3 * i + 3])
    if lens is None:
        return
    for time, depth in depth_images(recording):
        depth = np.where(depth > 0.0, depth, np.float32(nan))
        frame = DepthFrame(depth=depth, intrinsics=lens, oTc=SE3.Identity(), stamp=time)
        yield time, _IMAGE, frame


def _way(strips: list[Any]) -> Array | None:
    """The path whose line was drawn, heading along it; None without one."""
    if not strips:
        return None
    xy = np.array(strips[0])[:, :2]
    along = np.diff(xy, axis=0, append=2.0 * xy[-1:] - xy[-2:-1])
    return np.column_stack([xy, np.arctan2(along[:, 1], along[:, 0])])
