"""ROS 2 without ROS: messages, and a driver of robots by topics and actions over DDS."""

from hw.ros2.carrier import Route
from hw.ros2.gripper import GripperOptions, Ros2Gripper
from hw.ros2.messages import definition, encode, missing, moment
from hw.ros2.moving import ArmOptions, BaseOptions, Mover, Ros2Arm, Ros2Base
from hw.ros2.publisher import publisher
from hw.ros2.sensing import CameraOptions, LaserOptions, Ros2Camera, Ros2Laser, depth_of
