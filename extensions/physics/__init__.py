"""The physical world, in MuJoCo: motors move the robot, contacts decide what is held."""

from importlib.metadata import distributions

from config import extra
from hw import WorldError
from hw.sim import SimBody, SimulatedWorld
from robots import RobotDescription

_ENGINES = "mujoco-core", "mujoco"


def _body() -> type[SimBody]:
    """The physical body; refuses an engine that is another one than its package says.

    Two packages write one folder.
    """
    try:
        import mujoco
    except ModuleNotFoundError as error:
        if error.name != "mujoco":
            raise
        raise WorldError(f"the world `physics` needs an extra: {extra('physics')}") from None
    there = {one.name: one.version for one in distributions() if one.name in _ENGINES}
    if set(there.values()) != {mujoco.__version__} or not mujoco.__version__.startswith("4.0."):
        told = ", ".join(f"{name} {number}" for name, number in there.items())
        raise WorldError(
            f"the world `physics` needs one MuJoCo 4.0, here is {mujoco.__version__} of {told}, "
            'which share a folder: pip uninstall mujoco mujoco-core; pip install "mujoco==4.0.*" '
            '"frankie-task[physics]"'
        )
    from extensions.physics.physical_body import PhysicalBody

    return PhysicalBody


def _check(robot: RobotDescription) -> None:
    if not robot.arm.inertias:
        hint = "write `inertia` in the file of its arm, or take the world `kinematic`"
        raise WorldError(f"the links of {robot.name} have no inertias; {hint}")


physics = SimulatedWorld("physics", _body, _check)
