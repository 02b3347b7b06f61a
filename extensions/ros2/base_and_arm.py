"""A base and an arm in ROS 2."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import inf, radians
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from config.poses import MapFromOdometry
from extensions.ros2.carrier import FRESH
from extensions.ros2.checked_messages import joints, odometry, placed, transform
from extensions.ros2.map_source import MapSource
from extensions.ros2.messages import message, moment
from extensions.ros2.part import Ros2Options, Ros2Part
from hw import (
    OLDEST,
    ArmState,
    Array,
    BaseState,
    DriverContext,
    Fault,
    FaultKind,
    LocalisedPose,
    epoch,
)
from robots import Positive

_SHORTEST = 1e-3  # time of which a difference of positions is a velocity [s]


class BaseOptions(Ros2Options):
    """A base that follows `cmd_vel`."""

    odometry: str = "odom"  # nav_msgs/Odometry
    command: str = "cmd_vel"
    stamped: bool = False  # TwistStamped instead of Twist
    localisation: str = ""
    """Topic of its pose on the map (PoseWithCovarianceStamped, as `/amcl_pose`), or `/tf`; empty:
    the odometry is the place on the map."""
    map_frame: str = "map"  # of that pose
    odometry_frame: str = "odom"  # with `/tf`
    sigma: Positive = 0.05  # deviation of that pose along x, and along y [m]
    sigma_deg: Positive = 2.0


class Mover(Ros2Part):
    """A part that follows velocities; a subclass encodes them."""

    _size = 3  # of a velocity
    _prompt = -inf  # when its state came in time, last [s]

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

    def _missing(self, number: int) -> str:
        """Also what comes too late to be believed."""
        now = self._clock.now()
        if wrong := super()._missing(number):
            return wrong
        self._prompt = now if self._delay <= OLDEST else self._prompt
        if now - self._prompt <= self._silence:
            return ""
        late = f"{self._delay:.1f} s old when it comes, and {OLDEST:g} s at most will do"
        return f"{self._topic(0)} is {late}: look at the network, and at the clocks"


class Ros2Base(Mover):
    """A base whose odometry and localised pose come by topics."""

    _part = "base"

    def __init__(self, options: BaseOptions, context: DriverContext) -> None:
        self._type = f"geometry_msgs/msg/Twist{'Stamped' * options.stamped}"
        self._stamped, self._has_tf = options.stamped, options.localisation == "/tf"
        routes = [
            options.hears(options.odometry, "nav_msgs/msg/Odometry"),
            options.tells(options.command, self._type),
        ]
        on_map = options.map_frame, options.odometry_frame
        doors: dict[int, Callable[[Any], Any]] = {}
        doors[0] = partial(odometry, frame=options.odometry_frame if self._has_tf else "")
        if self._has_tf:  # a volatile one, and one with what was told before
            kind, slots = "tf2_msgs/msg/TFMessage", 64
            routes.append(options.hears("/tf", kind, slots=slots))
            routes.append(options.hears("/tf_static", kind, sensor=False, latched=True))
            doors |= dict.fromkeys((2, 3), partial(transform, parent=on_map[0], child=on_map[1]))
        elif topic := options.localisation:
            kind = "geometry_msgs/msg/PoseWithCovarianceStamped"
            routes.append(options.hears(topic, kind))
            routes.append(options.hears(topic, kind, sensor=False, latched=True))
            doors |= dict.fromkeys((2, 3), partial(placed, frame=on_map[0]))
        super().__init__(options, context.clock, routes, doors)
        sigmas = options.sigma, options.sigma, radians(options.sigma_deg)
        self._covariance = np.diag(np.square(sigmas))  # of what `/tf` tells
        self._state: BaseState | None = None
        self._localised: LocalisedPose | None = None
        self._mTo: MapFromOdometry | None = None
        self._source = MapSource() if options.localisation else None
        self._on_map = f"{' -> '.join(on_map)} on /tf" if self._has_tf else options.localisation

    def read(self) -> BaseState:
        """The newest odometry; of a silent base the last one, at rest, with a fault, now."""
        faults = self._faults()
        if not faults and (lost := self._unlocalised()):
            faults = (Fault(kind=FaultKind.STALE_POSE, text=lost, clearable=True),)
        state = self._state
        assert state is not None, "connect first"
        if any(fault.kind is FaultKind.CONNECTION for fault in faults):
            state = replace(state, stamp=self._clock.now(), twist=np.zeros(3))
        return replace(state, localised=self._localised, faults=faults)

    def recover(self) -> None:
        """Wait until its nodes are back, and what tells its place on the map, or HardwareError."""
        super().recover()
        self._wait(self._unlocalised)

    def _hear(self) -> None:
        for stamp, (oTb, twist) in self._new(0):
            self._state = BaseState(stamp=stamp, oTb=oTb, twist=twist)
        if self._source is not None and self._state is not None:
            for route in (3, 2):
                for stamp, told in self._new(route):
                    self._place(stamp, told, self._state, self._source, is_old=route == 3)

    def _place(
        self, stamp: float, told: Any, state: BaseState, source: MapSource, *, is_old: bool
    ) -> None:
        """Take over where the base is on the map; of `/tf`, if where odometry is has changed."""
        if is_old and (self._has_tf or source.has_told):
            return
        source.heard(self._clock.now(), state.oTb)
        if self._has_tf:
            if self._mTo is not None and told.isApprox(self._mTo):
                return
            self._mTo, stamp = told, state.stamp
            told = told * state.oTb, self._covariance
        mTb, covariance = told
        self._localised = LocalisedPose(
            stamp=stamp, mTb=mTb, covariance=covariance, source=self._on_map
        )

    def _unlocalised(self) -> str:
        """Why its place on the map is not told; empty if it is."""
        status = self._status.get()
        if self._source is None or self._state is None or status is None:
            return ""
        is_silent = self._source.is_silent(self._clock.now(), self._state.oTb)
        is_gone = not status[1 + 2]
        if self._source.has_told and not is_silent and not is_gone:
            return ""
        if self._has_tf and not self._source.has_told and self._taken[3] > -inf:
            return f"{self._on_map} stands on /tf_static alone, where nothing corrects it"
        if is_gone:
            kind = self._routes[2].type
            return f"nobody publishes {self._topic(2)} in {self._where} as {kind}: look at its node"
        if wrong := self._complaints.get(2) or self._complaints.get(3):
            return self._about(2, wrong)
        if not self._source.has_told:
            return f"{self._on_map} has told nothing yet: give the robot its first pose on the map"
        return f"{self._on_map} tells nothing any more: look at its node"

    def _tell(self, velocity: Array, holds: float = FRESH) -> None:
        self._publish(1, self._twist(velocity), self._twist(np.zeros(3), holds), holds)

    def _twist(self, velocity: Array, later: float = 0.0) -> Any:
        vx, vy, w = map(float, velocity)
        twist = {"linear": {"x": vx, "y": vy}, "angular": {"z": w}}
        if not self._stamped:
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

    _part = "arm"

    def __init__(self, options: ArmOptions, context: DriverContext) -> None:
        self._options, self._type = options, _TYPES[options.message]
        routes = [
            options.hears(options.states, "sensor_msgs/msg/JointState"),
            options.tells(options.command, self._type),
        ]
        doors = {0: partial(joints, names=options.joints)}
        super().__init__(options, context.clock, routes, doors)
        self._size = len(options.joints)
        self._state: ArmState | None = None

    def read(self) -> ArmState:
        """The newest joints; of a silent arm the last ones, at rest, with a fault, now."""
        faults, state = self._faults(), self._state
        assert state is not None, "connect first"
        if not faults:
            return state
        return replace(state, stamp=self._clock.now(), qd=np.zeros(self._size), faults=faults)

    def _hear(self) -> None:
        for stamp, (q, qd) in self._new(0):
            last = self._state or ArmState(stamp=-inf, q=q, qd=np.zeros(len(q)))
            if qd is None and (passed := stamp - last.stamp) > _SHORTEST:
                qd = (q - last.q) / passed
            elif qd is None:
                qd = last.qd
            self._state = ArmState(stamp=stamp, q=q, qd=qd)

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


def header(frame: str, later: float = 0.0) -> Any:
    """Of now, or of a moment later [s]."""
    stamp = moment(round(1e9 * (epoch() + later)))
    return message("std_msgs/msg/Header", stamp=stamp, frame_id=frame)
