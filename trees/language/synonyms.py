"""Words of other tree languages, and plain ones, with the word that is meant, for hints."""

from __future__ import annotations

from collections.abc import Mapping

NODES: Mapping[str, str] = {
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

CHOICES: Mapping[str, str] = {
    "biggest": "largest",
    "big": "largest",
    "widest": "largest",
    "tiniest": "smallest",
    "closest": "nearest",
    "any": "best",
    "violet": "purple",
    "magenta": "pink",
    "cyan": "blue",
}
