"""All that a model has to know to write a task, made from what is registered."""

from collections.abc import Iterator

import numpy as np

from config import quoted
from hw.sim import find_scene, load_fixtures, scene_names
from robots import Plane, half_extents, load_robot, robot_names
from trees import shipped
from trees.language import (
    COMPOSITES,
    FILE_KEYS,
    MODIFIERS,
    LeafType,
    Output,
    Parameter,
    describe_leaves,
    known_leaves,
)


def description(scene: str, *, short: bool) -> str:
    """The language, the robots and what stands in a scene; `short` is without explanations."""
    return "\n".join(_lines(scene, short))


def _lines(scene: str, short: bool) -> Iterator[str]:
    yield "# Keys of a task file"
    yield from (f"{key}: {about}" for key, about in FILE_KEYS.items())
    yield "# Composites: a node with one of these keys has children"
    yield from (
        f"{key}: {word.children}{'' if short else f'; {word.description}'}"
        for key, word in COMPOSITES.items()
    )
    yield "# Modifiers: keys beside the key of a node"
    yield from (
        f"{key}: {word.type or 'a condition'}{'' if short else f'; {word.description}'}"
        for key, word in MODIFIERS.items()
    )
    leaves = sorted(describe_leaves(known_leaves()).values(), key=lambda leaf: leaf.key)
    for title, asks in (("Conditions", True), ("Behaviours", False)):
        yield f"# {title}, and their parameters"
        for leaf in leaves:
            if leaf.is_condition is asks:
                yield from _leaf(leaf, short)
    yield "# An example"
    yield shipped("pick_one").read_text(encoding="utf-8")
    yield f"# Robots: {quoted(robot_names())}; scenes: {quoted(scene_names())}"
    frankie = load_robot("frankie")
    yield f"`frankie` starts at [0, 0]; its hand opens {frankie.gripper.opening:g} m"
    yield f"# What stands in the scene `{scene}`: middle and size [m]"
    for one in load_fixtures(find_scene(scene)):
        if not isinstance(one.shape, Plane):
            middle, size = one.pose.translation, 2.0 * np.abs(half_extents(one.shape))
            yield f"{one.name}: {np.round(middle, 3).tolist()} {np.round(size, 3).tolist()}"


def _leaf(leaf: LeafType, short: bool) -> Iterator[str]:
    names = (one.name if one.required else f"[{one.name}]" for one in leaf.described)
    yield f"{leaf.key}{': ' * bool(leaf.described)}{', '.join(names)}; {leaf.description}"
    if not short:
        yield from (f"  {_parameter(one)}" for one in leaf.described)


def _parameter(one: Parameter | Output) -> str:
    if isinstance(one, Output):
        return f"{one.name}: a key that takes {one.type}: {one.description}"
    default = "" if one.required or one.default is None else f" ({one.default})"
    return f"{one.name}: {one.type}{default}: {one.description}"
