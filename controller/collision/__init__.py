"""What robot and surroundings may come near to: their shapes, distances, and rows of the QP."""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from controller.collision.avoidance import Avoidance, Near
    from controller.collision.collision_model import CollisionModel, CollisionModels, PairKind
    from controller.collision.dampers import SLACK_COSTS, Dampers
    from controller.collision.proximity import Proximity
    from controller.collision.self_collision import SelfCollision
    from controller.collision.yielding import waits_for
else:
    __getattr__ = lazy_face(__name__)

__all__ = [
    "SLACK_COSTS",
    "Avoidance",
    "CollisionModel",
    "CollisionModels",
    "Dampers",
    "Near",
    "PairKind",
    "Proximity",
    "SelfCollision",
    "waits_for",
]
