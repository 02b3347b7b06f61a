"""Classes of random objects, each a function that returns convex parts at rest on z = 0."""

from hw.sim.objects.household import HOUSEHOLD
from hw.sim.objects.making import (
    MAX_HEIGHT,
    PAINT,
    Maker,
    ObjectClass,
    Parts,
    body_of,
    box,
    disc,
    fitting,
    longest,
    make_object,
    mass_properties,
    part,
)
from hw.sim.objects.modelled import MODELLED
from hw.sim.objects.modelling import (
    SIDES,
    corners_of,
    cut_out,
    hollow,
    lying,
    swept,
    turned,
    turned_over,
)

OBJECT_CLASSES = {**HOUSEHOLD, **MODELLED}
"""All classes that a scene may name; `lab` adds those that networks are trained and judged on."""
