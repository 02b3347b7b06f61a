"""What the parts in ROS 2 make of messages, and what they send; there is no robot."""

import subprocess
import sys
import time

import cv2
import numpy as np
import pytest

from extensions.ros2.base_and_arm import ArmOptions, BaseOptions, Ros2Arm, Ros2Base
from extensions.ros2.checked_messages import lens
from extensions.ros2.gripper import GripperOptions, Ros2Gripper
from extensions.ros2.messages import decode, encode, message, missing
from extensions.ros2.sensing import _maps, _metres
from hw import DriverContext, WallClock
from hw.clock import stopwatch
from robots import load_robot

pytestmark = pytest.mark.skipif(bool(missing()), reason=missing())
CONTEXT = DriverContext(robot=load_robot("frankie"), clock=WallClock())


def hand_over(part, route: int, *messages) -> None:
    """As the process that speaks DDS does."""
    for one in messages:
        data = one if isinstance(one, bytes) else encode(part._routes[route].type, one)
        part._rings[route].put(stopwatch(), data)


def test_commands_are_what_the_robots_file_says():
    """As their CDR has them: trajectories end at rest by themselves, the others are stopped."""
    qd, sent = np.full(7, 0.2), {}

    def tell(_, message, stop=None, *__):
        kind = message.__msgtype__
        sent[kind.rpartition("/")[2]] = decode(kind, encode(kind, message)), stop

    for kind in ("Float64MultiArray", "JointTrajectory", "JointJog"):
        arm = Ros2Arm(ArmOptions(joints=tuple("abcdefg"), message=kind), CONTEXT)
        arm._publish = tell
        arm._tell(qd)
    for stamped in (False, True):
        base = Ros2Base(BaseOptions(stamped=stamped), CONTEXT)
        base._publish = tell
        base._tell(np.array([0.1, 0.0, 0.2]))
    assert sent["Float64MultiArray"][0].data.tolist() == qd.tolist()
    assert not sent["Float64MultiArray"][1].data.any()
    assert sent["JointJog"][0].velocities.tolist() == qd.tolist()
    trajectory, stop = sent["JointTrajectory"]
    assert trajectory.joint_names == list("abcdefg")
    assert [point.velocities[0] for point in trajectory.points] == [0.2, 0.0]
    assert stop is None
    assert sent["Twist"][0].angular.z == sent["TwistStamped"][0].twist.angular.z == 0.2
    assert abs(sent["TwistStamped"][0].header.stamp.sec - time.time()) < 2.0


@pytest.mark.parametrize("source", ["/tf", "/amcl_pose"])
def test_the_pose_on_the_map_comes_by_tf_or_with_its_covariance(source):
    """Odometry is at (1, 0), turned to the left; its frame is at (10, 0) on the map."""
    base = Ros2Base(BaseOptions(localisation=source), CONTEXT)
    left = message("geometry_msgs/msg/Quaternion", z=np.sqrt(0.5), w=np.sqrt(0.5))
    odometry = message("nav_msgs/msg/Odometry")
    odometry.header.frame_id = "odom"
    odometry.pose.pose.position.x, odometry.pose.pose.orientation = 1.0, left
    odometry.twist.twist.linear.x = 0.3
    if source == "/tf":
        link = message("geometry_msgs/msg/TransformStamped", child_frame_id="odom")
        link.header.frame_id = "map"
        link.transform.translation.x, link.transform.rotation.w = 10.0, 1.0
        told = message("tf2_msgs/msg/TFMessage", transforms=[link])
    else:
        told = message("geometry_msgs/msg/PoseWithCovarianceStamped")
        told.header.frame_id = "map"
        told.pose.pose.position.x, told.pose.pose.orientation = 11.0, left
        told.pose.covariance[[0, 7, 35]] = 0.01, 0.02, 0.03
    hand_over(base, 0, odometry)
    hand_over(base, 2, told)
    base._hear()
    state = base._state
    assert state.twist.tolist() == [0.3, 0.0, 0.0]
    np.testing.assert_allclose(state.oTb.rotation[:, 0], [0.0, 1.0, 0.0], atol=1e-9)
    where = base._localised
    np.testing.assert_allclose(where.mTb.translation, [11.0, 0.0, 0.0])
    np.testing.assert_allclose(where.mTb.rotation, state.oTb.rotation, atol=1e-9)
    if source == "/amcl_pose":
        np.testing.assert_allclose(np.diag(where.covariance), (0.01, 0.02, 0.03))


@pytest.mark.parametrize("action", ["GripperCommand", "ParallelGripperCommand"])
def test_a_width_is_a_position_of_the_joint_in_both_actions(action):
    gripper = Ros2Gripper(GripperOptions(joint="finger", open=0.04, type=action), CONTEXT)
    goals = []

    def call(route, patience, kind, **fields):
        name = f"control_msgs/action/{action}_{kind}"
        request = message(f"{name}_Request", **fields)
        goals.append(decode(f"{name}_Request", encode(f"{name}_Request", request)))
        fields = {"accepted": True} if kind == "SendGoal" else {"status": 4}
        return message(f"{name}_Response", **fields)

    gripper._call = call
    gripper.grip(0.02, 15.0)
    goal = goals[0]
    if action == "GripperCommand":
        assert (goal.position, goal.max_effort) == (pytest.approx(0.01), 15.0)
    else:
        assert (goal.command.name, goal.command.position[0]) == (["finger"], pytest.approx(0.01))
    assert goals[1].goal_id.uuid.tolist() == goal.goal_id.uuid.tolist()


def test_without_an_address_nothing_but_loopback_is_heard():
    program = (
        "from socket import *\n"
        "from extensions.ros2.carrier import configuration, stay_on_loopback\n"
        "one = socket(AF_INET, SOCK_DGRAM); stay_on_loopback()\n"
        "print(one.getsockopt(SOL_SOCKET, SO_BINDTODEVICE, 16), configuration(''))"
    )
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True).stdout
    assert told.startswith("b'lo")
    assert "<AllowMulticast>false" in told


def test_depth_is_read_in_metres_row_by_row_and_out_of_a_png():
    rows = np.zeros((2, 3), ">f4")  # a row is longer than its pixels
    rows[:, :2] = [[0.5, np.nan], [1.0, 2.0]]
    fields = {"height": 2, "width": 2, "step": 12, "encoding": "32FC1", "is_bigendian": 1}
    image = message("sensor_msgs/msg/Image", **fields, data=rows.view(np.uint8).ravel())
    np.testing.assert_array_equal(_metres(image), rows[:, :2])
    millimetres = np.array([[0, 500], [1000, 2000]], np.uint16)
    png = b"\0" * 12 + cv2.imencode(".png", millimetres)[1].tobytes()
    fields = {"format": "16UC1; compressedDepth png", "data": np.frombuffer(png, np.uint8)}
    depth = _metres(message("sensor_msgs/msg/CompressedImage", **fields))
    np.testing.assert_allclose(depth, millimetres / 1000.0)


def test_images_of_the_cameras_own_intrinsics_stay_as_they_are():
    camera = CONTEXT.robot.camera
    info = message("sensor_msgs/msg/CameraInfo", width=640, height=480, k=camera.intrinsics.matrix)
    assert _maps(lens(info), camera) is None
