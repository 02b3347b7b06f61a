"""`frankie-task teach`: writes the present pose of a robot, or a path, to a file of places."""

import re
from collections.abc import Callable
from math import degrees
from pathlib import Path

import numpy as np
import pinocchio as pin

from app.choices import Form
from config import Diagnostics, UserError, YamlMap, read_yaml
from config.planar import yaw_of
from controller import RobotModel
from hw import Robot, WorldOptions, open_backend
from trees.language import NAMING_HINT, WORD


def teach(
    name: str,
    places: Path,
    *,
    robot: str,
    world: str,
    form: Form,
    replace: bool,
    armed: bool,
    more: Callable[[], bool] | None = None,
) -> str:
    """Read the pose of a robot and write it to a file; returns what was written.

    The robot, which must be `armed` if it is real, does not move. `form` is what of it is taught; a
    pose of the same name is refused unless `replace` is set. With `more` it is a path: a pose at
    each yes of it. Raises UserError: the name is invalid, or the file cannot be read or written;
    HardwareError: the robot cannot be read.
    """
    if not WORD.fullmatch(name):
        raise UserError(f"`{name}` cannot be the name of a pose; {NAMING_HINT}")
    text = _text(places)
    backend = open_backend(robot, world, WorldOptions(scene="household", armed=armed))
    try:
        backend.robot.connect()
        poses = path(backend.robot, form, more) if more else f" {_pose(backend.robot, form)}"
    finally:
        backend.robot.close()
    block = f"{name}:{poses}"
    try:
        places.write_text(_with(text, name, block, places, replace), encoding="utf-8")
    except OSError as error:
        raise UserError(f"{places}: cannot be written ({error.strerror})") from error
    return block


def _text(places: Path) -> str:
    if not places.exists():
        return ""
    diagnostics = Diagnostics(places)
    read = read_yaml(diagnostics)
    if read is None or not isinstance(read[1], YamlMap):
        raise UserError("\n".join(map(str, diagnostics.in_order())) or f"{places}: has no keys")
    return read[0]


def path(robot: Robot, form: Form, more: Callable[[], bool]) -> str:
    """The poses of a robot at each yes of `more`, each on a line."""
    poses = ""
    while more():
        poses += f"\n    - {_pose(robot, form)}"
    if not poses:
        raise UserError("a path has at least one pose")
    return poses


def _pose(robot: Robot, form: Form) -> str:
    """The pose as a task file writes it, to millimetres and tenths of a degree."""
    state = robot.read()
    if form is Form.ARM:
        slides = robot.description.arm.slides
        q = np.where(slides, state.q, np.degrees(state.q))
        return f"{{joints_deg: {_list(q, 3 if slides.any() else 1)}}}"
    if form is Form.BASE:
        turn = state.oTb.rotation
        heading = degrees(yaw_of(turn))
        at = _list(state.oTb.translation[:2], 3)
        return f"{{base: {at}, heading_deg: {_list([heading], 1)[1:-1]}}}"
    oTe = RobotModel(robot.description).end_effector(state.oTb, state.q)
    angles = _list(np.degrees(pin.rpy.matrixToRpy(oTe.rotation)), 1)
    return f"{{xyz: {_list(oTe.translation, 3)}, rpy_deg: {angles}}}"


def _list(numbers: object, digits: int) -> str:
    rounded = (round(float(number), digits) + 0.0 for number in np.asarray(numbers))
    return f"[{', '.join(f'{number:g}' for number in rounded)}]"


def _with(text: str, name: str, block: str, places: Path, replace: bool) -> str:
    """The text with the block below `poses:`, in place of what has the same name."""
    lines = [re.sub(r"^poses:\s*(\{\s*\}|null|~)", "poses:", one) for one in text.splitlines()]
    heads = [place for place, one in enumerate(lines) if re.match(r"poses:\s*(#.*)?$", one)]
    if not heads and re.search(r"^poses:", text, re.MULTILINE):
        raise UserError(f"{places}: write every pose on a line of its own below `poses:`")
    if not heads:
        lines += ["poses:"]
        heads = [len(lines) - 1]
    old = [place for place, one in enumerate(lines) if re.match(rf"\s+{name}:", one)]
    if old and not replace:
        raise UserError(f"{places}:{old[0] + 1}: `{name}` is there already; add --replace")
    start = end = old[0] if old else heads[0] + 1
    first, *others = block.splitlines()
    if old:
        indent, _, rest = lines[start].partition(name)
        end += 1
        while end < len(lines) and lines[end].startswith((f"{indent} ", f"{indent}-")):
            end += 1
        first += "".join(re.findall(r"\s#.*$", rest))
    lines[start:end] = [f"  {first}", *others]
    return "\n".join(lines) + "\n"
