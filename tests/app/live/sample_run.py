"""A synthetic run as snapshots: a robot drives to a container and looks into it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin
from pinocchio import SE3
from py_trees.common import Status

from app.live import SceneView, Snapshot
from app.live.nodes import NodeInfo, NodeStatus
from behaviours import Region
from controller import Command, PoseGoal, StepReport, robot_model
from hw import DepthFrame, RobotState
from hw.sim.camera.render import DepthRenderer
from perception.detected_grasp import Detection, GraspEstimate
from robots import Box, Capsule, Cylinder, Geom, Intrinsics, Plane, Sphere, load_robot

READY = load_robot("frankie").arm.ready

PERIOD = 0.02
RUNNING, SUCCESS, FAILURE, IDLE = Status.RUNNING, Status.SUCCESS, Status.FAILURE, Status.INVALID

TREE = tuple(
    NodeInfo(name=name, kind=kind, depth=depth)
    for depth, name, kind in (
        (0, "forever", "forever"),
        (1, "main", "sequence"),
        (2, "recover", "recover"),
        (2, "until empty", "until"),
        (3, "region empty?", "region_empty"),
        (3, "pick", "retry"),
        (4, "pick once", "sequence"),
        (5, "open gripper", "open_gripper"),
        (5, "navigate to above_container", "navigate"),
        (5, "grasp 🤖", "grasp"),
        (3, "navigate to table", "navigate"),
        (3, "place", "place"),
    )
)

_LETTERS = {".": IDLE, "R": RUNNING, "S": SUCCESS, "F": FAILURE}
STATUSES = tuple(
    # from this tick on, in preorder
    (tick, tuple(_LETTERS[letter] for letter in letters))
    for tick, letters in (
        (0, "RRR........."),
        (30, "RRSRFRRR...."),
        (50, "RRSRFRRSR..."),
        (170, "RRSRFRRSSR.."),
        (250, "RRSRFRFSSF.."),
    )
)


def _at(x: float, y: float, z: float) -> SE3:
    return SE3(np.eye(3), np.array([x, y, z]))


SCENE = SceneView(
    fixtures=(
        Geom(Plane(), _at(0, 0, 0), "floor"),
        Geom(Box((0.25, 0.21, 0.228)), _at(3.0, 0, 0.228), "pedestal", (120, 110, 100)),
        Geom(Box((0.003, 0.186, 0.025)), _at(2.777, 0, 0.481), "wall", (90, 120, 160)),
        Geom(Box((0.003, 0.186, 0.025)), _at(3.223, 0, 0.481), "wall", (90, 120, 160)),
        Geom(Box((0.226, 0.003, 0.025)), _at(3.0, 0.183, 0.481), "wall", (90, 120, 160)),
        Geom(Box((0.226, 0.003, 0.025)), _at(3.0, -0.183, 0.481), "wall", (90, 120, 160)),
        Geom(Box((0.6, 0.3, 0.02)), _at(0, 1.6, 0.48), "table", (140, 100, 60)),
    ),
    objects=(
        ("box 1", (Geom(Box((0.02, 0.03, 0.02)), _at(0, 0, 0)),)),
        (
            "mug",
            (
                Geom(Cylinder(0.03, 0.04), _at(0, 0, 0), colour=(220, 80, 60)),
                Geom(Box((0.012, 0.005, 0.02)), _at(0.04, 0, 0), colour=(220, 80, 60)),
            ),
        ),
        (
            "ball and bar",
            (
                Geom(Sphere(0.025), _at(0, 0, 0), colour=(90, 180, 90)),
                Geom(Capsule(0.012, 0.04), _at(0, 0, 0.03), colour=(60, 60, 200)),
            ),
        ),
    ),
)
SCENE = replace(
    SCENE,
    regions=(Region(name="container", mTr=_at(3.0, 0.0, 0.556), size=np.array([0.44, 0.36, 0.2])),),
    goals=(("above_container", _at(2.95, 0.0, 0.85)), ("at_table", _at(0.0, 1.4, 0.85))),
)
OBJECTS = (_at(2.95, 0.05, 0.476), _at(3.06, -0.05, 0.496), _at(2.92, -0.09, 0.481))
LENS = Intrinsics(width=160, height=120, fx=96.0, fy=96.0, cx=79.5, cy=59.5)
_GOAL = PoseGoal(target=SE3(pin.utils.rotate("x", np.pi), np.array([2.95, 0.0, 0.85])))
_MODEL = robot_model("frankie")


def statuses(tick: int) -> tuple[Status, ...]:
    """Status of the nodes in a tick."""
    return [row for start, row in STATUSES if start <= tick][-1]


def frame(stamp: float, oTc: SE3, lens: Intrinsics = LENS) -> DepthFrame:
    """A depth image of the scene, with a hole in a corner."""
    moved = [
        part.moved(pose)
        for (_, parts), pose in zip(SCENE.objects, OBJECTS, strict=True)
        for part in parts
    ]
    depth = np.round(DepthRenderer(lens).render([*SCENE.fixtures, *moved], oTc), 3)
    depth[:5, :7] = np.nan
    return DepthFrame(depth=depth.astype(np.float32), intrinsics=lens, oTc=oTc, stamp=stamp)


def detection(seen: DepthFrame) -> Detection:
    """A grasp on the mug, with a bump of quality around it."""
    oTg = SE3(pin.utils.rotate("x", np.pi), OBJECTS[1].translation)
    camera = seen.oTc.actInv(oTg.translation)
    pixel = seen.intrinsics.fx * camera[:2] / camera[2] + [seen.intrinsics.cx, seen.intrinsics.cy]
    size = float(seen.intrinsics.height)
    crop = ((seen.intrinsics.width - size) / 2, 0.0, size)
    v, u = np.mgrid[0:300, 0:300] * size / 300
    distance = (u + crop[0] - pixel[0]) ** 2 + (v - pixel[1]) ** 2
    angle = float(np.arctan2(*(seen.oTc.rotation.T @ oTg.rotation[:, 1])[[1, 0]]))
    grasp = GraspEstimate(
        oTg=oTg,
        width=0.06,
        opening=0.08,
        quality=0.9,
        stamp=seen.stamp,
        pixel=(float(pixel[0]), float(pixel[1])),
        angle=angle,
    )
    return Detection(
        grasps=(grasp,),
        reason="",
        quality=np.exp(-distance / (0.003 * size**2)).astype(np.float32),
        crop=crop,
        stamp=seen.stamp,
    )


def snapshot(tick: int, lens: Intrinsics = LENS) -> Snapshot:
    """The run in one tick; looks into the container from tick 170 on."""
    stamp = tick * PERIOD
    drive = float(np.clip((tick - 50) / 120, 0, 1))
    oTb = _at(2.35 * drive, 0.0, 0.0)
    q = READY + 0.1 * np.sin(stamp + np.arange(7))
    oTe = _MODEL.end_effector(oTb, q)
    looking = tick >= 170
    seen = frame(stamp, oTe * _at(0.065, 0.0, -0.098), lens) if looking else None
    found = detection(seen) if seen is not None and tick % 20 else None
    message = f"{(300 - tick) / 100:.2f} m to go ⏱"
    return Snapshot(
        tick=tick,
        time=stamp,
        state=RobotState(
            stamp=stamp,
            oTb=oTb,
            base_twist=np.array([0.5, 0.0, 0.0]),
            q=q,
            qd=np.zeros(7),
            gripper_width=0.04 + 0.03 * np.sin(stamp),
            gripper_moving=False,
        ),
        command=Command(
            base_twist=np.array([0.5 * np.cos(stamp), 0.0, 0.1]),
            qd=0.5 * np.cos(np.arange(7) + stamp),
        ),
        nodes=tuple(
            NodeStatus(status=status, message=message if status == RUNNING else "nothing held")
            for status in statuses(tick)
        ),
        goal=_GOAL if tick >= 50 else None,
        report=StepReport(
            arrived=False,
            position_error=3.0 - tick / 100,
            orientation_error=0.2,
            manipulability=0.08 + 0.01 * np.sin(stamp),
            heading_error=0.1,
            slack=0.01 * abs(np.sin(3 * stamp)),
            solved=True,
            bTe=oTb.actInv(oTe),
        ),
        seconds=0.001 * (2.0 + (tick % 7) / 10),
        objects=OBJECTS,
        frame=seen,
        detection=found,
        grasp=found.grasps[0] if found else None,
        locked=tick >= 230,
    )


def moment(tick: int) -> Snapshot:
    """The same in the middle of a task, with a change of a node."""
    return replace(snapshot(tick), placed=7, attempts=8, changed=True)


def run(ticks: int, lens: Intrinsics = LENS) -> Iterator[Snapshot]:
    """The run from its beginning."""
    return (snapshot(tick, lens) for tick in range(ticks))
