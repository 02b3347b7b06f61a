"""Classes of random objects: of the scenes, of training, and, never trained on, of evaluation."""

from hw.sim.objects.heldout import HELDOUT
from hw.sim.objects.household import HOUSEHOLD
from hw.sim.objects.modelled import MODELLED
from hw.sim.objects.random_bodies import RANDOM_BODIES
from hw.sim.objects.train import TRAIN

OBJECT_CLASSES = {**HOUSEHOLD, **TRAIN, **HELDOUT, **MODELLED, **RANDOM_BODIES}
"""All classes that a scene may name."""
