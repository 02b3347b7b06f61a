"""Rules of a task on a robot, in a scene, each with a code; and all rules."""

from collections.abc import Mapping

from config import YAML_RULES, Rule
from trees.language import LANGUAGE_RULES

_BOX = "scene: single\nregions: {box: {centre: [3, 0, 0.556], size: [0.44, 0.36, 0.2]}}\n"
_SHELF = "scene: shelf\nregions:\n  low: {centre: [2.52, 0, 0.85], size: [0.2, 0.44, 0.2]}\n"
_TROLLEY = _SHELF + "  trolley: {centre: [0, 1.6, 0.85], size: [0.5, 0.4, 0.2]}\n"

REACH = Rule(
    "R501",
    "A place where a leaf goes is in reach and free, and the hand does not point up there.",
    "poses: {up: {xyz: [2, 0, 1.85], rpy_deg: [180, 0, 0]}}\ntree: {navigate: {to: up}}",
    "poses: {up: {xyz: [2, 0, 0.85], rpy_deg: [180, 0, 0]}}\ntree: {navigate: {to: up}}",
)
COME_TO = Rule(
    "R502",
    "From some stance the hand reaches into a region, in a direction that its leaf allows.",
    _SHELF + "tree: {grasp: {within: low, approach: down}}",
    _SHELF + "tree: {grasp: {within: low}}",
)
SURFACE = Rule(
    "R503",
    "Things stand on the bottom face of a region, where the scene has a surface.",
    _BOX.replace("0.556", "0.8") + "tree: {grasp: {within: box}}",
    _BOX + "tree: {grasp: {within: box}}",
)
SET_DOWN = Rule(
    "R504",
    "Things are set down as they were gripped: below a board, by a hand that gripped them tilted.",
    _TROLLEY + "tree: {sequence: [{grasp: {within: trolley}}, {place: {on: low}}]}",
    _TROLLEY
    + "tree: {sequence: [{grasp: {within: trolley, least_tilt_deg: 45}}, {place: {on: low}}]}",
)
SCENE_FILE = Rule(
    "R505",
    "The scene of a task is a shipped one or a file without mistakes.",
    "scene: singel\ntree: open_gripper",
    "scene: single\ntree: open_gripper",
)
FURNITURE = Rule(
    "R506",
    "`on` names a piece of furniture of the scene.",
    _BOX.replace("]}}", "], on: tabel}}") + "tree: {grasp: {within: box}}",
    _BOX.replace("]}}", "], on: table}}") + "tree: {grasp: {within: box}}",
)

_HERE = tuple(one for one in list(globals().values()) if isinstance(one, Rule))
RULES: Mapping[str, Rule] = {one.code: one for one in (*YAML_RULES, *LANGUAGE_RULES, *_HERE)}
"""All rules by their codes."""
