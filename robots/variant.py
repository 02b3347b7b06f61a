"""A robot file like another one, with another base speed."""

from __future__ import annotations

import json
from pathlib import Path

from config import ConfigError, read_config
from robots.description import with_base_speed, with_reverse_speed
from robots.load import SHIPPED, load_real_robot, load_robot, robot_file
from robots.schema import RobotFile


def write_variant(
    robot: str | Path, folder: Path, *, base_speed: float | None, reverse_speed: float | None
) -> Path:
    """Write a robot file like another one, under the same name.

    Args:
        robot: name of a shipped robot, or path of a robot file.
        folder: of the new file; it is made.
        base_speed: largest speed of the base [m/s]; None keeps it.
        reverse_speed: largest speed backwards [m/s]; None keeps its share of the forward speed.

    Raises:
        ConfigError: there is no such robot, it is a real one, or its file has a mistake.
    """
    if load_real_robot(robot) is not None:
        raise ConfigError(f"{robot}: is a real robot; its speeds are those of its file")
    source = robot_file(robot)
    description = load_robot(robot)
    if base_speed is not None:
        description = with_base_speed(description, base_speed)
    if reverse_speed is not None:
        description = with_reverse_speed(description, reverse_speed)
    limits = description.limits
    content = read_config(source, RobotFile, context=(source.parent, SHIPPED)).model_dump(
        mode="json", exclude_none=True
    )
    content["base"]["limits"] |= {
        "speed": [float(value) for value in limits.base_twist],
        "reverse": float(limits.base_reverse),
    }
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / f"{source.stem}.yaml"
    file.write_text(json.dumps(content, indent=2), encoding="utf-8")
    return file
