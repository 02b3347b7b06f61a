"""Where the robots of the package example-robot-data are."""

from pathlib import Path

import pinocchio as pin

EXAMPLES = next(p for p in Path(pin.__file__).parents if p.name == "cmeel.prefix") / (
    "share/example-robot-data/robots"
)
