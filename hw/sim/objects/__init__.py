"""Classes of random objects, in five sets.

The shipped scenes use `HOUSEHOLD`. The grasp network is trained on `HOUSEHOLD`, `TRAIN` and
`RANDOM_BODIES`, and evaluated on `HELDOUT`, which is never trained on. `MODELLED` have curved and
hollow bodies.
"""

from hw.sim.objects.heldout import HELDOUT
from hw.sim.objects.household import HOUSEHOLD
from hw.sim.objects.modelled import MODELLED
from hw.sim.objects.random_bodies import RANDOM_BODIES
from hw.sim.objects.train import TRAIN

OBJECT_CLASSES = {**HOUSEHOLD, **TRAIN, **HELDOUT, **MODELLED, **RANDOM_BODIES}
"""All classes that a scene may name."""
