"""What is true of a robot, once: its description in YAML files, and the shapes it is made of.

`load_robot` reads `frankie`, `omni` or the file of another robot into a `RobotDescription`, which
controller, simulator, perception, viewer and judges share.
"""

from robots.description import (
    ArmDescription,
    BaseDescription,
    CameraDescription,
    GripperDescription,
    Intrinsics,
    Limits,
    RobotDescription,
    with_base_speed,
    with_reverse_speed,
)
from robots.load import load_robot, robot_names
from robots.shapes import (
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
    coal_geometry,
    from_rounded_boxes,
    half_extents,
    hull_of,
    reach,
    rounded_box,
    volume,
)

__all__ = [
    "GREY",
    "ArmDescription",
    "Array",
    "BaseDescription",
    "Box",
    "CameraDescription",
    "Capsule",
    "Colour",
    "Cylinder",
    "Geom",
    "GripperDescription",
    "Hull",
    "Intrinsics",
    "Limits",
    "Plane",
    "RobotDescription",
    "Shape",
    "Sphere",
    "Triangles",
    "bounding_radius",
    "coal_geometry",
    "from_rounded_boxes",
    "half_extents",
    "hull_of",
    "load_robot",
    "reach",
    "robot_names",
    "rounded_box",
    "volume",
    "with_base_speed",
    "with_reverse_speed",
]
