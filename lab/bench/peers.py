"""Peers of the controller: mink, pink, and the paper's published example on the Robotics Toolbox.

All get our robot, goals, control period, joint limits and speed limits. The base is a chain of
virtual joints that stay at zero, as in our model: goals are in the base frame.
"""

from collections.abc import Callable
from math import atan2
from typing import Any, TypeAlias

import numpy as np
import pinocchio as pin
from pinocchio import SE3

from config import extra
from config.poses import MapPose
from config.reader import ConfigError
from controller import (
    Array,
    Command,
    KinematicState,
    MotionGoal,
    PoseGoal,
    RobotModel,
    StepReport,
    Surroundings,
)
from lab.bench.simulated_motion import Step

Velocities: TypeAlias = Callable[[Array, SE3], Array | None]
"""From joints (n,), base first, and the goal in the base frame to velocities (n,); None where the
QP has no solution."""

_GAIN = 4.0  # of mink and pink: speed per metre and radian of error, as our servo's [1/s]
_POSTURE_COST = 1e-3  # of the motion that the end effector leaves free, with a task cost of 1


def _pink(model: RobotModel, period: float) -> Velocities:
    import pink
    from pink.limits import ConfigurationLimit, VelocityLimit

    chain = model.chain.copy()
    chain.lowerPositionLimit, chain.upperPositionLimit = model.position_limits
    chain.velocityLimit = model.velocity_limits[1]
    ready = model.joints(model.description.arm.ready).copy()
    here = pink.Configuration(chain, chain.createData(), ready)
    tool = pink.tasks.FrameTask("tool", 1.0, 1.0, gain=_GAIN * period)
    rest = pink.tasks.PostureTask(cost=_POSTURE_COST, gain=_GAIN * period)
    rest.set_target(ready)
    limits = [ConfigurationLimit(chain), VelocityLimit(chain)]

    def velocities(joints: Array, goal: SE3) -> Array | None:
        here.update(joints)
        tool.set_target(goal)
        try:
            v: Array = pink.solve_ik(here, [tool, rest], period, solver="quadprog", limits=limits)
        except pink.exceptions.PinkError:
            return None
        return v

    return velocities


def _mink(model: RobotModel, period: float) -> Velocities:
    import mink

    chain = _mujoco_chain(model)
    here = mink.Configuration(chain)
    tool = mink.FrameTask("tool", "site", 1.0, 1.0, gain=_GAIN * period)
    rest = mink.PostureTask(chain, cost=_POSTURE_COST, gain=_GAIN * period)
    rest.set_target(model.joints(model.description.arm.ready).copy())
    speeds = {str(number): speed for number, speed in enumerate(model.velocity_limits[1])}
    limits = [mink.ConfigurationLimit(chain), mink.VelocityLimit(chain, speeds)]

    def velocities(joints: Array, goal: SE3) -> Array | None:
        here.update(joints)
        x, y, z, w = pin.Quaternion(goal.rotation).coeffs()
        tool.set_target(mink.SE3(np.array([w, x, y, z, *goal.translation])))
        try:
            v: Array = mink.solve_ik(here, [tool, rest], period, solver="daqp", limits=limits)
        except mink.MinkError:
            return None
        return v

    return velocities


def _mujoco_chain(model: RobotModel) -> Any:
    """The chain of our model as a MuJoCo model; its joints are called by their numbers."""
    import mujoco

    spec, chain = mujoco.MjSpec(), model.chain
    spec.compiler.degree = False
    body = spec.worldbody
    for number, (place, screw) in enumerate(_joints(model)):
        at = pin.SE3ToXYZQUAT(place)
        body = body.add_body(pos=at[:3], quat=at[[6, 3, 4, 5]], mass=1.0, inertia=np.ones(3))
        slides = screw[:3].any()
        kind = mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE
        low, high = model.position_limits[:, number]
        bounded = {"range": (low, high)} if np.isfinite(low) else {}
        axis = screw[:3] if slides else screw[3:]
        body.add_joint(name=str(number), type=kind, axis=axis, **bounded)
    at = pin.SE3ToXYZQUAT(chain.frames[chain.getFrameId("tool")].placement)
    body.add_site(name="tool", pos=at[:3], quat=at[[6, 3, 4, 5]])
    return spec.compile()


def _joints(model: RobotModel) -> list[tuple[SE3, Array]]:
    """Placement on the one before and screw (6,), linear first, of every joint of the chain."""
    places, joints = list(model.chain.jointPlacements)[1:], list(model.chain.joints)[1:]
    return [(place, joint.createData().S) for place, joint in zip(places, joints, strict=True)]


def _rtb(model: RobotModel, period: float) -> Velocities:
    import qpsolvers
    import roboticstoolbox as rtb

    n, n_base = model.n, model.n_base
    parts = []
    for number, (place, screw) in enumerate(_joints(model)):
        moves = getattr(rtb.ET, ("tx", "ty", "tz", "Rx", "Ry", "Rz")[int(np.argmax(screw))])
        low, high = np.clip(model.position_limits[:, number], -999999.0, 999999.0)
        parts += [rtb.ET.SE3(place.homogeneous), moves(qlim=[low, high])]
    frame = model.chain.frames[model.chain.getFrameId("tool")].placement
    parts.append(rtb.ET.SE3(frame.homogeneous))
    robot, arm = rtb.Robot(rtb.ETS(parts)), rtb.ETS(parts[2 * n_base :])
    turns = model.turning
    speeds = np.concatenate([model.velocity_limits[1], np.full(6, 10.0)])

    def velocities(joints: Array, goal: SE3) -> Array | None:
        bTe = robot.fkine(joints).A
        error = float(np.abs((np.linalg.inv(bTe) @ goal.homogeneous)[:3, 3]).sum())
        twist, _ = rtb.p_servo(bTe, goal.homogeneous, 1.5)
        twist[3:] *= 1.3
        Q = np.diag([0.01 / error] * n_base + [0.01] * (n - n_base) + [1.0 / error] * 6)
        c = np.zeros(n + 6)
        c[n_base:n] = -arm.jacobm(joints[n_base:]).ravel()
        c[turns] = -0.5 * atan2(bTe[1, 3], bTe[0, 3])
        dampers, room = np.zeros((n + 6, n + 6)), np.zeros(n + 6)
        dampers[:n, :n], room[:n] = robot.joint_velocity_damper(q=joints, ps=0.1, pi=0.9, n=n)
        J = np.hstack([robot.jacobe(joints), np.eye(6)])
        x = qpsolvers.solve_qp(Q, c, dampers, room, J, twist, -speeds, speeds, solver="quadprog")
        if x is None:
            return None
        qd: Array = x[:n] * (0.7 / error if error > 0.5 else 1.4)
        return qd

    return velocities


_MAKERS = {"rtb": _rtb, "mink": _mink, "pink": _pink}
_NEITHER = "acceleration, reverse, collisions, stances"
LACKS = {"rtb": f"{_NEITHER}, speed", "mink": _NEITHER, "pink": _NEITHER}
"""By the name of a peer, what it does without: limits of acceleration, reverse and other speeds."""


def peer_step(name: str, model: RobotModel, period: float) -> Step:
    """The step of a peer.

    Raises:
        ConfigError: it is not installed.
    """
    try:
        velocities = _MAKERS[name](model, period)
    except ImportError as error:
        how = "pip install --no-deps mink" if name == "mink" else extra("peers")
        raise ConfigError(f"{name} needs {error.name}: {how}") from None
    solved, unsolved = (_report(solved) for solved in (True, False))

    def step(
        state: KinematicState,
        goal: MotionGoal[MapPose] | None,
        last: Command,
        surroundings: Surroundings,
    ) -> tuple[Command, StepReport]:
        assert isinstance(goal, PoseGoal)
        found = velocities(model.joints(state.q), state.mTb.actInv(goal.target))
        if found is None:
            return model.command(np.zeros(model.n)), unsolved
        return model.command(found), solved

    return step


def _report(solved: bool) -> StepReport:
    """What run and judge ask of a report; peers make none."""
    unknown = float("nan")
    return StepReport(
        arrived=False,
        position_error=unknown,
        orientation_error=unknown,
        manipulability=unknown,
        heading_error=unknown,
        bTe=SE3.Identity(),
        solved=solved,
    )
