"""The research interface of the Panda, version 5, and of its hand, version 3, as bytes.

All numbers are little-endian and packed. Layouts: the headers that libfranka 0.9.2 is built with.
"""

import struct
from enum import IntEnum
from typing import NamedTuple

from drivers.panda import Mode

VERSION, PORT = 5, 1337
HAND_VERSION, HAND_PORT = 3, 1338

_ERRORS = """
joint_position_limits_violation cartesian_position_limits_violation
self_collision_avoidance_violation joint_velocity_violation cartesian_velocity_violation
force_control_safety_violation joint_reflex cartesian_reflex max_goal_pose_deviation_violation
max_path_pose_deviation_violation cartesian_velocity_profile_safety_violation
joint_position_motion_generator_start_pose_invalid
joint_motion_generator_position_limits_violation joint_motion_generator_velocity_limits_violation
joint_motion_generator_velocity_discontinuity joint_motion_generator_acceleration_discontinuity
cartesian_position_motion_generator_start_pose_invalid
cartesian_motion_generator_elbow_limit_violation
cartesian_motion_generator_velocity_limits_violation
cartesian_motion_generator_velocity_discontinuity
cartesian_motion_generator_acceleration_discontinuity
cartesian_motion_generator_elbow_sign_inconsistent cartesian_motion_generator_start_elbow_invalid
force_controller_desired_force_tolerance_violation start_elbow_sign_inconsistent
communication_constraints_violation power_limit_violation
cartesian_motion_generator_joint_position_limits_violation
cartesian_motion_generator_joint_velocity_limits_violation
cartesian_motion_generator_joint_velocity_discontinuity
cartesian_motion_generator_joint_acceleration_discontinuity
cartesian_position_motion_generator_invalid_frame controller_torque_discontinuity
joint_p2p_insufficient_torque_for_planning tau_j_range_violation instability_detected
joint_move_in_wrong_direction cartesian_spline_motion_generator_violation
joint_via_motion_generator_planning_joint_limit_violation base_acceleration_initialization_timeout
base_acceleration_invalid_reading
"""
ERRORS = tuple(_ERRORS.split())  # errors in the order of the flags of a state


class Command(IntEnum):
    """Requests to the arm over TCP; 4 to 11 set something."""

    CONNECT = 0
    MOVE = 1
    STOP_MOVE = 2
    GET_CARTESIAN_LIMIT = 3
    AUTOMATIC_ERROR_RECOVERY = 12
    LOAD_MODEL_LIBRARY = 13


class MoveStatus(IntEnum):
    """Status of a motion."""

    SUCCESS = 0
    STARTED = 1
    PREEMPTED = 2
    NOT_POSSIBLE = 3
    INVALID_ARGUMENT = 5
    REFLEX_ABORTED = 6
    EMERGENCY_ABORTED = 7
    INPUT_ERROR = 8
    ABORTED = 9


SUCCESS, NOT_POSSIBLE, MANUAL_RECOVERY = 0, 1, 2  # answers to other requests
JOINT_VELOCITY = 1  # the emulated motion generator
JOINT_IMPEDANCE, NO_CONTROLLER = 0, 3  # the emulated controller, and none

HEADER = struct.Struct("<III")  # command, its number, size of the whole message
CONNECT = struct.Struct("<HH")  # version, port for states; the same for the hand
MOVE = struct.Struct("<II6d")  # controller, motion generator, permitted deviations
CONNECTED = struct.Struct("<BH")  # status and version of the server

STATE = struct.Struct("<Q96d13d13d4d56d26d25d9d28d14d2B41B41BBd")  # 2373 bytes, 1000 times a second
MOTION = struct.Struct("<Q7d7d16d6d2d2B7d")  # 370 bytes: the motion command, once for each state

HAND_HEADER = struct.Struct("<HII")
HAND_STATUS = struct.Struct("<H")
HAND_CONNECTED = struct.Struct("<HH")
HAND_STATE = struct.Struct("<IddBH")
"""Number, width and largest width [m], whether grasped, temperature [degrees C]."""


class HandCommand(IntEnum):
    """Requests to the hand over TCP."""

    CONNECT = 0
    HOMING = 1
    GRASP = 2
    MOVE = 3
    STOP = 4


class HandStatus(IntEnum):
    """Status of a motion of the fingers."""

    SUCCESS = 0
    FAIL = 1
    UNSUCCESSFUL = 2
    ABORTED = 3


class MotionCommand(NamedTuple):
    """Motion command, as far as emulated."""

    number: int  # of the state that it answers
    qd: tuple[float, ...]  # (7,) [rad/s]
    finished: bool


def read_motion(packet: bytes) -> MotionCommand | None:
    """Decode a motion command; None if it is malformed."""
    if len(packet) != MOTION.size:
        return None
    values = MOTION.unpack(packet)
    return MotionCommand(values[0], values[8:15], bool(values[40]))


_S = 0.5**0.5
_F_T_EE = (_S, -_S, 0, 0, _S, _S, 0, 0, 0, 0, 1, 0, 0, 0, 0.1034, 1)
_I = (1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)
_INERTIA = (0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017)
_FRAMES = (*_F_T_EE, *_I, *_F_T_EE, *_I)
_LOADS = (0.73, *_INERTIA, -0.01, 0, 0.03, 0.0, *(0.0,) * 12)


def _zeros(count: int) -> tuple[float, ...]:
    return (0.0,) * count


def pack_state(
    number: int,
    pose: tuple[float, ...],
    joints: tuple[tuple[float, ...], ...],
    errors: bytes,
    last_errors: bytes,
    mode: int,
    success_rate: float,
) -> bytes:
    """A state of the arm, `number` milliseconds after power-on.

    `pose` (16,) is the end effector on the foot, column-major [m]; `joints` are (7,) measured
    positions and velocities, commanded positions, velocities and accelerations [rad, s]; errors
    are (41,) flags.
    """
    q, qd, q_d, qd_d, qdd_d = joints
    elbow, moving = (q[2], -1.0), mode == Mode.MOVE
    return STATE.pack(
        number,
        *(*pose, *pose, *_FRAMES, *_LOADS, *elbow, *elbow, *_zeros(21)),
        *(*q, *q_d, *qd, *qd_d, *qdd_d),
        *(*_zeros(26 + 7 + 3 * 6), 0.0, 0.0, -9.81, *elbow, *_zeros(4), *pose, *_zeros(12)),
        *(*q, *qd),
        JOINT_VELOCITY + 1 if moving else 0,
        JOINT_IMPEDANCE if moving else NO_CONTROLLER,
        *(*errors, *last_errors, mode, success_rate),
    )
