"""What the author of a behaviour, a robot or a script needs, in one place.

A behaviour derives from `Leaf` or `Condition` and is offered by an entry point of the group
`frankie_task.behaviours`, a `Recogniser` by one of `frankie_task.recognisers`. A driver is an
`Arm`, `Base`, `Gripper`, `DepthCamera` or `LaserScanner` that a function of `DriverOptions` and
`DriverContext` makes, offered in `frankie_task.drivers`; an `Observer` and a world likewise
(docs/extending.md). A script calls `run_task`; `frankie_task.control`
is the controller alone.
What is not here may change without notice.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from frankie_task.face import *
else:

    def __getattr__(name: str) -> object:
        import frankie_task.face

        return getattr(frankie_task.face, name)
