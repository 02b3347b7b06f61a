"""Types of ROS 2 as its packages have them, with the CDR of cyclonedds; images by rosbags."""

import time

import numpy as np
from cyclonedds.idl import make_idl_struct, types
from rosbags.typesys import Stores, get_typestore

TYPES = """
builtin_interfaces.msg.Time sec:int32 nanosec:uint32
std_msgs.msg.Header stamp:Time frame_id:str
sensor_msgs.msg.JointState header:Header name:str* position:float64* velocity:float64* effort:float64*
geometry_msgs.msg.Vector3 x:float64 y:float64 z:float64
geometry_msgs.msg.Twist linear:Vector3 angular:Vector3
geometry_msgs.msg.Point x:float64 y:float64 z:float64
geometry_msgs.msg.Quaternion x:float64 y:float64 z:float64 w:float64
geometry_msgs.msg.Pose position:Point orientation:Quaternion
geometry_msgs.msg.PoseWithCovariance pose:Pose covariance:float64[36]
geometry_msgs.msg.PoseWithCovarianceStamped header:Header pose:PoseWithCovariance
geometry_msgs.msg.TwistWithCovariance twist:Twist covariance:float64[36]
nav_msgs.msg.Odometry header:Header child_frame_id:str pose:PoseWithCovariance twist:TwistWithCovariance
std_msgs.msg.MultiArrayDimension label:str size:uint32 stride:uint32
std_msgs.msg.MultiArrayLayout dim:MultiArrayDimension* data_offset:uint32
std_msgs.msg.Float64MultiArray layout:MultiArrayLayout data:float64*
sensor_msgs.msg.Image header:Header height:uint32 width:uint32 encoding:str is_bigendian:uint8 step:uint32 data:uint8*
sensor_msgs.msg.RegionOfInterest x_offset:uint32 y_offset:uint32 height:uint32 width:uint32 do_rectify:bool
sensor_msgs.msg.CameraInfo header:Header height:uint32 width:uint32 distortion_model:str d:float64* k:float64[9] r:float64[9] p:float64[12] binning_x:uint32 binning_y:uint32 roi:RegionOfInterest
sensor_msgs.msg.LaserScan header:Header angle_min:float32 angle_max:float32 angle_increment:float32 time_increment:float32 scan_time:float32 range_min:float32 range_max:float32 ranges:float32* intensities:float32*
geometry_msgs.msg.Transform translation:Vector3 rotation:Quaternion
geometry_msgs.msg.TransformStamped header:Header child_frame_id:str transform:Transform
tf2_msgs.msg.TFMessage transforms:TransformStamped*
nav2_msgs.msg.BehaviorTreeStatusChange timestamp:Time node_name:str uid:uint16 previous_status:str current_status:str
nav2_msgs.msg.BehaviorTreeLog timestamp:Time event_log:BehaviorTreeStatusChange*
unique_identifier_msgs.msg.UUID uuid:uint8[16]
control_msgs.action.GripperCommand_SendGoal_Request client:uint64 number:int64 goal_id:UUID position:float64 max_effort:float64
control_msgs.action.GripperCommand_SendGoal_Response client:uint64 number:int64 accepted:bool stamp:Time
control_msgs.action.GripperCommand_GetResult_Request client:uint64 number:int64 goal_id:UUID
control_msgs.action.GripperCommand_GetResult_Response client:uint64 number:int64 status:int8 position:float64 effort:float64 stalled:bool reached_goal:bool
action_msgs.srv.CancelGoal_Request client:uint64 number:int64 goal_id:UUID stamp:Time
"""  # noqa: E501


def read_types() -> dict[str, type]:
    found: dict[str, type] = {}

    def one(word: str):
        name, is_many = word.removesuffix("*"), word.endswith("*")
        name, _, count = name.removesuffix("]").partition("[")
        plain = {"str": str, "bool": bool}.get(name) or found.get(name) or getattr(types, name)
        if is_many:
            return types.sequence[plain]
        return types.array[plain, int(count)] if count else plain

    for line in TYPES.strip().splitlines():
        full, *fields = line.split()
        package, kind, name = full.split(".")
        pairs = {key: one(word) for key, _, word in (field.partition(":") for field in fields)}
        found[name] = make_idl_struct(name, f"{package}.{kind}.dds_.{name}_", pairs)
    return found


T = read_types()
STORE = get_typestore(Stores.ROS2_JAZZY)
T["Image"].serialize = lambda sample, **_: sample.cdr


def header():
    now = time.time_ns()
    return T["Header"](T["Time"](now // 10**9, now % 10**9), "odom")


def image(depth: np.ndarray, head):
    """16UC1 in millimetres, 0 where missing."""
    ros, rows = STORE.types, np.nan_to_num(depth * 1000.0).astype("<u2")
    stamp = ros["builtin_interfaces/msg/Time"](head.stamp.sec, head.stamp.nanosec)
    one = ros["sensor_msgs/msg/Image"](
        ros["std_msgs/msg/Header"](stamp, "sensor"), *rows.shape, "16UC1", 0, 2 * rows.shape[1],
        rows.view(np.uint8).ravel(),
    )  # fmt: skip
    sample = T["Image"](head, 0, 0, "", 0, 0, [])
    sample.cdr = bytes(STORE.serialize_cdr(one, "sensor_msgs/msg/Image"))
    return sample
