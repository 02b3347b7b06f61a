"""Navigation of the base: floor map, path planning, and driving."""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from controller.floor.base_drive import Lead, Pose2D, drive_along, wrap
    from controller.floor.cost_field import CostField
    from controller.floor.floor_map import COLUMN, FloorMap
    from controller.floor.route import Route, plain_lead
else:
    __getattr__ = lazy_face(__name__)

__all__ = [
    "COLUMN",
    "CostField",
    "FloorMap",
    "Lead",
    "Pose2D",
    "Route",
    "drive_along",
    "plain_lead",
    "wrap",
]
