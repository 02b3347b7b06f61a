"""A base and an arm in ROS 2."""

from collections.abc import Sequence
from dataclasses import replace
from math import radians
from typing import Annotated, Any, Literal

import numpy as np
import pinocchio as pin
from pinocchio import SE3, Quaternion
from pydantic import Field

from hw.clock import epoch
from hw.drivers import DriverContext
from hw.ros2.carrier import FRESH
from hw.ros2.messages import message, moment
from hw.ros2.part import Ros2Options, Ros2Part
from hw.state import ArmState, Array, BaseState, LocalisedPose
from robots import Positive


class BaseOptions(Ros2Options):
    """A base that follows `cmd_vel`."""

    odometry: str = "odom"  # nav_msgs/Odometry
    command: str = "cmd_vel"
    stamped: bool = False  # TwistStamped instead of Twist
    localisation: str = ""
    """Topic of its pose on the map (PoseWithCovarianceStamped, as `/amcl_pose`), or `/tf`; empty:
    the odometry is the place on the map."""
    map_frame: str = "map"  # with `/tf`
    odometry_frame: str = "odom"
    sigma: Positive = 0.05  # deviation of that pose along x, and along y [m]
    sigma_deg: Positive = 2.0


class Mover(Ros2Part):
    """A part that follows velocities; a subclass encodes them."""

    _size = 3  # of a velocity

    def send(self, velocity: Array) -> Array:
        """Follow a velocity; zero while there is a fault, or if it is not finite."""
        is_good = np.isfinite(velocity).all() and not self._trouble()
        applied = np.array(velocity, dtype=float) if is_good else np.zeros(self._size)
        self._tell(applied)
        return applied

    def send_last(self, velocity: Array, holds: float) -> None:
        """Follow a velocity until the robot's own time-out, or a stop that comes after [s]."""
        self._tell(velocity, holds)

    def stop(self) -> None:
        """Command rest."""
        self._tell(np.zeros(self._size))

    def _tell(self, velocity: Array, holds: float = FRESH) -> None:
        raise NotImplementedError


class Ros2Base(Mover):
    """A base whose odometry and localised pose come by topics."""

    def __init__(self, options: BaseOptions, context: DriverContext) -> None:
        self._options = options
        self._type = f"geometry_msgs/msg/Twist{'Stamped' * options.stamped}"
        self._has_tf = options.localisation == "/tf"
        routes = [
            options.hears(options.odometry, "nav_msgs/msg/Odometry"),
            options.tells(options.command, self._type),
        ]
        if self._has_tf:
            routes.append(options.hears("/tf", "tf2_msgs/msg/TFMessage", slots=64))
        elif options.localisation:
            kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
            routes.append(options.hears(options.localisation, kind, sensor=False, latched=True))
        super().__init__(options, context.clock, routes)
        self._state: BaseState | None = None
        self._localised: LocalisedPose | None = None
        self._mTo: SE3 | None = None

    def read(self) -> BaseState:
        """The newest odometry; of a silent base the last one, at rest, with a fault, now."""
        faults, state = self._faults(), self._state
        assert state is not None, "connect first"
        if faults:
            state = replace(state, stamp=self._clock.now(), twist=np.zeros(3), faults=faults)
        return replace(state, localised=self._localised)

    def _hear(self) -> bool:
        before = self._state
        for stamp, one in self._new(0):
            twist = one.twist.twist
            velocity = np.array([twist.linear.x, twist.linear.y, twist.angular.z])
            self._state = BaseState(stamp=stamp, wTb=_pose(one.pose.pose), twist=velocity)
        if self._options.localisation and self._state is not None:
            for stamp, one in self._new(2):
                if self._has_tf:
                    self._corrected(one, self._state)
                else:
                    rows = np.reshape(one.pose.covariance, (6, 6))[np.ix_((0, 1, 5), (0, 1, 5))]
                    self._localised = LocalisedPose(
                        stamp=stamp, mTb=_pose(one.pose.pose), covariance=rows
                    )
        return self._state is not before

    def _corrected(self, transforms: Any, state: BaseState) -> None:
        """Take over where odometry is on the map, if that has changed."""
        options = self._options
        sigmas = options.sigma, options.sigma, radians(options.sigma_deg)
        for one in transforms.transforms:
            frames = one.header.frame_id.lstrip("/"), one.child_frame_id.lstrip("/")
            mTo = _planar(one.transform.translation, one.transform.rotation)
            is_new = self._mTo is None or not mTo.isApprox(self._mTo)
            if frames == (options.map_frame, options.odometry_frame) and is_new:
                self._mTo = mTo
                self._localised = LocalisedPose(
                    stamp=state.stamp, mTb=mTo * state.wTb, covariance=np.diag(np.square(sigmas))
                )

    def _tell(self, velocity: Array, holds: float = FRESH) -> None:
        self._publish(1, self._twist(velocity), self._twist(np.zeros(3), holds), holds)

    def _twist(self, velocity: Array, later: float = 0.0) -> Any:
        vx, vy, w = map(float, velocity)
        twist = {"linear": {"x": vx, "y": vy}, "angular": {"z": w}}
        if not self._options.stamped:
            return message(self._type, **twist)
        return message(self._type, header=header("base_link", later), twist=twist)


class ArmOptions(Ros2Options):
    """An arm that follows joint velocities."""

    joints: Annotated[tuple[str, ...], Field(min_length=1, max_length=12)]
    """Their names, in the order of the robot's description."""
    states: str = "joint_states"  # sensor_msgs/JointState
    command: str = "velocity_controller/commands"
    message: Literal["Float64MultiArray", "JointTrajectory", "JointJog"] = "Float64MultiArray"


_TYPES = {
    "Float64MultiArray": "std_msgs/msg/Float64MultiArray",
    "JointTrajectory": "trajectory_msgs/msg/JointTrajectory",
    "JointJog": "control_msgs/msg/JointJog",
}


class Ros2Arm(Mover):
    """An arm whose joints come by name, in any order."""

    def __init__(self, options: ArmOptions, context: DriverContext) -> None:
        self._options, self._type = options, _TYPES[options.message]
        routes = [
            options.hears(options.states, "sensor_msgs/msg/JointState"),
            options.tells(options.command, self._type),
        ]
        super().__init__(options, context.clock, routes)
        joints = ", ".join(options.joints)
        self._lacks = f"{options.name(options.states)} does not tell all of {joints}"
        self._size = len(options.joints)
        self._state: ArmState | None = None

    def read(self) -> ArmState:
        """The newest joints; of a silent arm the last ones, at rest, with a fault, now."""
        faults, state = self._faults(), self._state
        assert state is not None, "connect first"
        if not faults:
            return state
        return replace(state, stamp=self._clock.now(), qd=np.zeros(self._size), faults=faults)

    def _hear(self) -> bool:
        before = self._state
        for stamp, one in self._new(0):
            if (rows := rows_of(one, self._options.joints)) is not None:
                q, last = one.position[rows], self._state
                qd = np.zeros(self._size)
                if len(one.velocity) == len(one.name):
                    qd = one.velocity[rows]
                elif last is not None and stamp > last.stamp:
                    qd = (q - last.q) / (stamp - last.stamp)
                self._state = ArmState(stamp=stamp, q=q, qd=qd)
        return self._state is not before

    def _tell(self, qd: Array, holds: float = FRESH) -> None:
        if self._options.message == "JointTrajectory":  # ends at rest by itself
            self._publish(1, self._trajectory(qd))
        else:
            stop = self._velocities(np.zeros(self._size), holds)
            self._publish(1, self._velocities(qd), stop, holds)

    def _velocities(self, qd: Array, later: float = 0.0) -> Any:
        if self._options.message == "Float64MultiArray":
            return message(self._type, data=qd)
        head, names = header("", later), list(self._options.joints)
        return message(self._type, header=head, joint_names=names, velocities=qd, duration=FRESH)

    def _trajectory(self, qd: Array) -> Any:
        """In `FRESH` to a velocity, and in as long again to rest."""
        zero = np.zeros(self._size)
        q, now = (zero, zero) if self._state is None else (self._state.q, self._state.qd)
        reached = q + FRESH * (now + qd) / 2.0
        ends = (reached, qd, FRESH), (reached + FRESH * qd / 2.0, zero, 2.0 * FRESH)
        points = [
            {"positions": q, "velocities": v, "time_from_start": {"nanosec": round(1e9 * after)}}
            for q, v, after in ends
        ]
        return message(self._type, joint_names=list(self._options.joints), points=points)


def rows_of(states: Any, joints: Sequence[str]) -> list[int] | None:
    """Where the joints stand in a JointState; None if one is not there."""
    places = {name: k for k, name in enumerate(states.name)}
    return [places[name] for name in joints] if places.keys() >= set(joints) else None


def header(frame: str, later: float = 0.0) -> Any:
    """Of now, or of a moment later [s]."""
    stamp = moment(round(1e9 * (epoch() + later)))
    return message("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def _pose(pose: Any) -> SE3:
    return _planar(pose.position, pose.orientation)


def _planar(position: Any, orientation: Any) -> SE3:
    turn = Quaternion(orientation.w, orientation.x, orientation.y, orientation.z).normalized()
    yaw = pin.log3(turn.toRotationMatrix())[2]
    return SE3(pin.utils.rotate("z", yaw), np.array([position.x, position.y, 0.0]))
