"""Collision avoidance: shapes, distances, and the constraints of the QP made from them."""

from typing import TYPE_CHECKING

from config import lazy_face

if TYPE_CHECKING:
    from controller.collision.avoidance import CollisionAvoidance, NearestPair
    from controller.collision.collision_model import CollisionModel, CollisionModels, PairKind
    from controller.collision.distance_constraints import SLACK_COSTS, DistanceConstraints
    from controller.collision.moving_obstacles import waits_for
    from controller.collision.proximity import Proximity
    from controller.collision.self_collision import SelfCollision
else:
    __getattr__ = lazy_face(__name__)

__all__ = [
    "SLACK_COSTS",
    "CollisionAvoidance",
    "CollisionModel",
    "CollisionModels",
    "DistanceConstraints",
    "NearestPair",
    "PairKind",
    "Proximity",
    "SelfCollision",
    "waits_for",
]
