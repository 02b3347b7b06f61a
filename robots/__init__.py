"""Robot descriptions in YAML files, and the shapes that robots are made of."""

from robots.description import (
    ArmDescription,
    BaseDescription,
    CameraDescription,
    GripperDescription,
    Intrinsics,
    LaserDescription,
    Limits,
    RobotDescription,
    Swivel,
    at_pace,
    with_base_speeds,
)
from robots.drivers import (
    KINDS,
    SIMULATED,
    Driver,
    DriverOptions,
    SpeedRange,
    find_driver,
    has_driver,
    installed_drivers,
)
from robots.load import (
    SHIPPED,
    RealRobot,
    load_real_robot,
    load_robot,
    robot_names,
    robot_texts,
)
from robots.schema import MOST_JOINTS, CameraFile, RobotFile
from robots.schema_geometry import NotNegative, Positive
from robots.schema_hardware import HardwareFile, Port, Text
from robots.shapes import (
    CORNERS,
    GREY,
    Array,
    Box,
    Capsule,
    Colour,
    Cylinder,
    Geom,
    Hull,
    Plane,
    Shape,
    Sphere,
    Triangles,
    bounding_radius,
    centroid,
    coal_geometry,
    from_rounded_boxes,
    half_extents,
    hull_of,
    reach,
    rounded_box,
    volume,
)
