"""Arguments of a leaf that are right one by one and do not fit each other.

Each function is the `misfit` of one or more leaves, see `Leaf.misfit`. `check` asks them before a
run, and a task is checked faster than what the leaves need is imported: nothing heavy is imported
here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from behaviours.key import Key
from config import suggest

BLANK = "{value}"
"""In a text, what the value takes the place of."""
_ANY_BLANK = re.compile(r"\{\w*\}")
_CHOOSING = ("choose", "kind", "colour", "min_width_mm", "max_width_mm")
"""The parameters of leaves that choose."""


def of_choice(arguments: Mapping[str, object]) -> str:
    """Widths between which nothing lies, or a kind that nobody knows."""
    least, most = arguments.get("min_width_mm"), arguments.get("max_width_mm")
    if isinstance(least, float) and isinstance(most, float) and least > most:
        return (
            f"has a least width of {least:g} mm and a largest of {most:g} mm, between which "
            "nothing is; exchange them"
        )
    kind = arguments.get("kind")
    if isinstance(kind, str):
        from perception import known_classes

        if kind not in (known := known_classes(kind)).recognisers:
            hint = known.problems[0] if known.problems else suggest(kind, known.recognisers)
            return f"asks for a `{kind}`, which no recogniser knows; {hint}"
    return ""


def of_grasp(arguments: Mapping[str, object]) -> str:
    """A choice that does not fit, one among a single object, or a neighbour of anything."""
    words = [word for word in (*_CHOOSING, "neighbour") if word in arguments]
    if (wrong := of_choice(arguments)) or not words:
        return wrong
    if isinstance(arguments.get("within"), Key):
        return (
            f"chooses by `{words[0]}` among one object, that of `within`; leave it out, or name a "
            "region"
        )
    says = {word: arguments[word] for word in words if word != "neighbour"}
    if arguments.get("neighbour") is True and says in ({}, {"choose": "best"}):
        return (
            "takes a neighbour, and nothing says of which object; add `choose: largest`, "
            "`colour` or a width"
        )
    return ""


def of_question(arguments: Mapping[str, object]) -> str:
    """A choice that does not fit, or none."""
    if len(arguments) == 1:
        return "asks nothing of its object; add `colour`, `min_width_mm` or `max_width_mm`"
    return of_choice(arguments)


def of_way(arguments: Mapping[str, object]) -> str:
    """Both ways to say where, or neither."""
    goes = [arguments.get(name) or 0.0 for name in ("forward_m", "turn_deg")]
    if (arguments.get("to") is None) != (goes == [0.0, 0.0]):
        return ""
    return "says both or neither; say either where `to`, or how far by the other two"


def of_text(arguments: Mapping[str, object]) -> str:
    """A blank without a value, a value without its blank, or another blank."""
    text, value = arguments.get("text"), arguments.get("value")
    if not isinstance(text, str):
        return ""
    if odd := [blank for blank in _ANY_BLANK.findall(text) if blank != BLANK]:
        return f"`{odd[0]}` in the text is filled by nothing; write {BLANK} and give `value`"
    if (value is not None) != (BLANK in text):
        return f"has only one of {BLANK} and `value`; write {BLANK} where the value belongs"
    return ""
