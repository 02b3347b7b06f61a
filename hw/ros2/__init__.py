"""Driver of robots that speak ROS 2, without ROS: topics and actions over DDS."""

from hw.ros2.gripper import GripperOptions, Ros2Gripper
from hw.ros2.messages import missing
from hw.ros2.moving import ArmOptions, BaseOptions, Ros2Arm, Ros2Base
from hw.ros2.sensing import CameraOptions, LaserOptions, Ros2Camera, Ros2Laser
