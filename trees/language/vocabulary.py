"""The words of the language: composites and modifiers, and the keys that are neither."""

from __future__ import annotations

from collections.abc import Mapping

from trees.language.composite_words import COMPOSITES
from trees.language.modifier_words import MODIFIERS

__all__ = ["CHILDREN", "COMPOSITES", "MEANT", "MODIFIERS", "NAME", "RESERVED", "SUBTREE"]

CHILDREN = "children"
"""The key of the children where a composite has options."""

NAME = "name"
"""The key that names a node."""

SUBTREE = "subtree"
"""The key of a node that stands for the tree of another file."""

RESERVED = frozenset({NAME, SUBTREE, *COMPOSITES, *MODIFIERS})
"""Words that no leaf may take as its key."""

MEANT: Mapping[str, str] = {
    "selector": "`fallback`",
    "select": "`fallback`",
    "priority": "`fallback` or `reactive_fallback`",
    "inverter": "the modifier `invert: true`, or `not` for a condition",
    "repeater": "the modifier `repeat`",
    "loop": "`forever`, `until`, or the modifier `repeat`",
    "if": "`unless` or `while` beside a node, `switch`, or a `fallback`",
    "if_then_else": "`switch`, or a `fallback`",
    "and": "`all_of`",
    "or": "`any_of`",
    "script": "`set` or `add`",
    "delay": "`wait`, or the modifier `delay_s`",
    "sleep": "`wait`",
    "guard": "the modifier `while`",
    "condition": "the key of the condition itself",
    "action": "the key of the behaviour itself",
    "timeout": "the modifier `timeout_s`",
    "cooldown": "the modifier `cooldown_s`",
    "force_fail": "the modifier `force_failure`",
    "include": "`subtree`",
    "for": "`for_each`, or the modifier `repeat`",
    "print": "`say`",
    "pick": "`grasp`, then `retreat_check`",
    "pick_up": "`grasp`, then `retreat_check`",
    "put": "`place`",
    "drop": "`place`, or `open_gripper`",
    "release": "`place`, or `open_gripper`",
    "close_gripper": "`grasp`",
    "go": "`navigate`",
    "goto": "`navigate`",
    "go_to": "`navigate`",
    "move": "`navigate`, `drive`, or `move_arm`",
    "move_to": "`navigate`",
    "move_base": "`drive`, or `navigate` to a base pose",
}
"""What people mean by words of other tree languages, and by plain ones."""
