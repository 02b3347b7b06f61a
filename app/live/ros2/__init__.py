"""Runs as messages of ROS 2 or Foxglove: into MCAP files, to Foxglove, and over DDS."""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from app.live.ros2.dds import published
    from app.live.ros2.foxglove import served, write_mcap
else:
    __getattr__ = lazy_face(__name__)
