"""Behaviour `snapshot`: keep a picture of the camera."""

from typing import ClassVar

from py_trees.common import Status

from behaviours.core.arguments import validate_file
from behaviours.core.context import Context
from behaviours.core.leaf import Leaf
from behaviours.views.viewpoint import GLANCE_PATIENCE


class Snapshot(Leaf):
    """Keep the next picture of the camera, colours and depth, in the folder of the run.

    The robot stands still for it. `FILE.depth.png` has millimetres, `FILE.png` the colours if the
    camera sees any; a second picture of the same name gets a number. The summary names them. Fails
    when the camera gives no usable picture.

    Args:
        file: name of the picture, without an ending.
    """

    key: ClassVar[str] = "snapshot"
    moves: ClassVar[bool] = False
    validate = staticmethod(validate_file)

    def __init__(self, name: str, context: Context, *, file: str) -> None:
        super().__init__(name, context)
        if wrong := self.validate({"file": file}):
            raise ValueError(wrong)
        self._file = file

    def initialise(self) -> None:
        """What is seen from now on counts."""
        self._since, self._begun = self.context.state.stamp, self.context.clock.now()

    def update(self) -> Status:
        """One tick."""
        context, stamp = self.context, self.context.state.stamp
        frame = context.vision.new_frame()
        if frame is not None and frame.stamp >= self._since and not context.vision.blindness(stamp):
            name = context.log.keep(self._file, frame)
            context.log.say(context.clock.now(), f"picture {name}")
            return self.success(f"kept as {name}")
        if context.clock.now() - self._begun > GLANCE_PATIENCE:
            return self.failure(context.vision.blindness(stamp) or "no camera frame")
        return self.running("waiting for a picture")
