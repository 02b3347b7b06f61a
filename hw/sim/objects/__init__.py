"""Every kind of object that the simulator can make from a seed, in three collections.

`HOUSEHOLD` fills the shipped scenes. `WORKSHOP` joins it where the grasp network learns. `UNSEEN`
is what nothing is ever learnt from: grasps on it tell how well others will be grasped.
"""

from hw.sim.objects.heldout import UNSEEN
from hw.sim.objects.household import HOUSEHOLD
from hw.sim.objects.making import (
    MAX_FOOTPRINT,
    MAX_HEIGHT,
    MAX_LENGTH,
    Kind,
    fitting,
    make_object,
)
from hw.sim.objects.train import WORKSHOP

KINDS: dict[str, Kind] = {**HOUSEHOLD, **WORKSHOP, **UNSEEN}
"""Every kind of object that a scene may ask for."""

__all__ = [
    "HOUSEHOLD",
    "KINDS",
    "MAX_FOOTPRINT",
    "MAX_HEIGHT",
    "MAX_LENGTH",
    "UNSEEN",
    "WORKSHOP",
    "Kind",
    "fitting",
    "make_object",
]
