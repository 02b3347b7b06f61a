"""Validation of incompatible arguments: each is valid alone, but not together with the others.

Each function is the `validate` of one or more leaves, see `Leaf.validate`. `check` calls it before
a run, so nothing heavy is imported here.
"""

import re
from collections.abc import Mapping

from behaviours.core.parameter_types import Key
from config import Hint, suggest

PLACEHOLDER = "{value}"
"""In a text, what the value takes the place of."""
_ANY_PLACEHOLDER = re.compile(r"\{\w*\}")
_FILE = re.compile(r"[A-Za-z0-9_-]{1,60}")
_PLACES_OF = {"pitch_m": ("on",), "within_m": ("at", "onto"), "within_deg": ("at",)}
_CHOICE_PARAMETERS = ("choose", "kind", "colour", "min_width_mm", "max_width_mm")


def validate_choice(arguments: Mapping[str, object]) -> str:
    """A minimum width above the maximum, or an unknown kind."""
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
            text = f"asks for a `{kind}`, which no recogniser knows; {hint}"
            return Hint(text, kind, getattr(hint, "meant", ""))
    return ""


def validate_grasp(arguments: Mapping[str, object]) -> str:
    """An invalid choice, a choice within a single object, or a neighbour of no chosen object."""
    words = [word for word in (*_CHOICE_PARAMETERS, "neighbour") if word in arguments]
    if (wrong := validate_choice(arguments)) or not words:
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


def validate_compare(arguments: Mapping[str, object]) -> str:
    """Both comparisons, or neither."""
    if ("equals" in arguments) is not ("least" in arguments):
        return ""
    return "says both or neither of `equals` and `least`; say one"


def validate_drive(arguments: Mapping[str, object]) -> str:
    """A pose and a relative motion, or neither."""
    goes = [arguments.get(name) or 0.0 for name in ("forward_m", "turn_deg")]
    if (arguments.get("to") is None) != (goes == [0.0, 0.0]):
        return ""
    return "says both or neither; say either where `to`, or how far by the other two"


def validate_file(arguments: Mapping[str, object]) -> str:
    """A name that is more than a word."""
    file = arguments.get("file")
    if not isinstance(file, str) or _FILE.fullmatch(file):
        return ""
    return f"has the file name `{file}`; write at most 60 letters, digits, `-` and `_`"


def validate_place(arguments: Mapping[str, object]) -> str:
    """Not exactly one place, or a parameter of another kind of place."""
    where = [name for name in ("on", "at", "onto") if arguments.get(name) is not None]
    if len(where) != 1:
        given = "all of " + ", ".join(where) if where else "no place"
        return f"is given {given}; give one of `on`, `at` and `onto`"
    for name, owners in _PLACES_OF.items():
        if name in arguments and where[0] not in owners:
            return f"has `{name}`, which belongs to `{owners[0]}`; leave it out"
    return ""


def validate_text(arguments: Mapping[str, object]) -> str:
    """A placeholder without a value, a value without its placeholder, or another placeholder."""
    text, value = arguments.get("text"), arguments.get("value")
    if not isinstance(text, str):
        return ""
    if odd := [blank for blank in _ANY_PLACEHOLDER.findall(text) if blank != PLACEHOLDER]:
        text = f"`{odd[0]}` in the text is filled by nothing; write {PLACEHOLDER} and give `value`"
        return Hint(text, odd[0], PLACEHOLDER if value is not None else "")
    if (value is not None) != (PLACEHOLDER in text):
        where = f"write {PLACEHOLDER} where the value belongs"
        return f"has only one of {PLACEHOLDER} and `value`; {where}"
    return ""
