"""Object classes of training and, never trained on, of evaluation; scenes of lab may name them."""

from hw.sim.objects import OBJECT_CLASSES
from lab.grasps.objects.heldout import HELDOUT
from lab.grasps.objects.random_bodies import RANDOM_BODIES
from lab.grasps.objects.training_classes import TRAIN

OBJECT_CLASSES.update({**TRAIN, **HELDOUT, **RANDOM_BODIES})
