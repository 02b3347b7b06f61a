"""Classes of random objects, in five sets.

The shipped scenes use `HOUSEHOLD`. The grasp network is trained on `HOUSEHOLD`, `TRAIN` and
`RANDOM_BODIES`, and evaluated on `HELDOUT`, which is never trained on. `MODELLED` have curved and
hollow bodies.
"""

from hw.sim.objects.heldout import HELDOUT
from hw.sim.objects.household import HOUSEHOLD
from hw.sim.objects.making import (
    DENSITY,
    FRICTION,
    MAX_FOOTPRINT,
    MAX_HEIGHT,
    MAX_LENGTH,
    PAINT,
    PALETTE,
    ObjectClass,
    fitting,
    make_object,
)
from hw.sim.objects.modelled import MODELLED
from hw.sim.objects.random_bodies import RANDOM_BODIES
from hw.sim.objects.train import TRAIN

OBJECT_CLASSES: dict[str, ObjectClass] = {
    **HOUSEHOLD,
    **TRAIN,
    **HELDOUT,
    **MODELLED,
    **RANDOM_BODIES,
}
"""All classes that a scene may name."""

__all__ = [
    "DENSITY",
    "FRICTION",
    "HELDOUT",
    "HOUSEHOLD",
    "MAX_FOOTPRINT",
    "MAX_HEIGHT",
    "MAX_LENGTH",
    "MODELLED",
    "OBJECT_CLASSES",
    "PAINT",
    "PALETTE",
    "RANDOM_BODIES",
    "TRAIN",
    "ObjectClass",
    "fitting",
    "make_object",
]
