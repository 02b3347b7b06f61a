"""Reading mappings: known keys, and errors about unknown and missing ones."""

import re
from collections.abc import Collection, Iterator, Mapping
from typing import Any

from config import (
    Diagnostics,
    Hint,
    Location,
    YamlEntry,
    YamlMap,
    YamlScalar,
    YamlValue,
    describe,
    nearest,
    quoted,
    suggest,
)
from trees.language import rules
from trees.language.leaf_type import LeafType
from trees.words import MODIFIERS, NAME, NamedValue

WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")  # names of parameters, keys, poses, regions, tasks

_OTHER_NAMES: Mapping[str, str] = {
    "selector": "`fallback`",
    **dict.fromkeys(("go", "goto", "go_to", "move_to"), "`navigate`"),
    **dict.fromkeys(("speak", "tell", "print", "announce"), "`say`"),
    **dict.fromkeys(("pick", "pick_up"), "`grasp`"),
    **dict.fromkeys(("put", "put_down"), "`place`"),
    **dict.fromkeys(("picture", "photo"), "`snapshot`"),
    "follow_path": "`for_each: {item: p, in: PATH, do: {navigate: {to: $p, straight: true}}}`",
    **dict.fromkeys(("times", "repetitions"), "`repeat`"),
    **dict.fromkeys(("attempts", "tries"), "`retry`"),
    "inverter": "`not: condition`",
    "loop": "`forever`, `until`, or the modifier `repeat`",
    "if": "`unless` or `while` beside a node, `switch`, or a `fallback`",
    "and": "`sequence`",
    "or": "`fallback`",
    "sleep": "`wait`",
    "guard": "the modifier `while`",
    "condition": "the key of the condition itself",
    "action": "the key of the behaviour itself",
    "include": "`subtree`",
    "close_gripper": "`grasp`, which closes the fingers",
}
"""What nodes and modifiers of other tree languages are called here."""

FORMER_WORDS: Mapping[str, tuple[str, str]] = {
    "reactive_sequence": ("`while: condition` beside its node", "sequence"),
    "reactive_fallback": ("`unless: condition` beside its node", "fallback"),
    "all_of": ("`sequence`, which asks conditions alone at every tick", "sequence"),
    "any_of": ("`fallback`, which asks conditions alone at every tick", "fallback"),
    "wait_until": ("`until: condition`", "until"),
    "force_success": ("`force: success`", ""),
    "force_failure": ("`force: failure`", ""),
    "cooldown_s": ("`wait: {duration_s: ...}` behind the node", ""),
    "equals": ("`compare: {value: ..., equals: ...}`", ""),
    "at_least": ("`compare: {value: ..., least: ...}`", ""),
    "arm_at": ("`near: {pose: POSTURE}`", ""),
    "region_free": ("`not: {object_visible: {within: ...}}`", ""),
    "looks_like": ("`detect`, which lists only what has its `colour` and width", ""),
    "time_between": ("a job of cron that runs the task then", ""),
    "resuming_sequence": ("`sequence`, and ask what is done: `fallback: [condition, node]`", ""),
    "invert": ("`not: condition`; `force: failure` beside what cannot fail", ""),
    "delay_s": ("`sequence: [wait: {duration_s: ...}, node]`", ""),
    "once": ("the node before the loop, or `unless` beside it, which asks a key that it sets", ""),
}
"""What to write instead of words that were removed, and the word that asks conditions alone."""

_OTHER_SENSE = (
    *("above", "after", "before", "behind", "below", "beside", "from", "max", "min", "near"),
    *("not", "off", "out", "outside", "over", "under", "until", "without"),
)
"""Names of parameters that mean something of their own, whatever else would fit there."""

ABSENT: Any = None  # the default of a field that may be left out, but not be null

NAMING_HINT = "use letters, digits and `_`, and begin with a letter"


def fields(
    value: YamlValue,
    subject: str,
    diagnostics: Diagnostics,
    *,
    required: Collection[str] = (),
    optional: Collection[str] = (),
) -> Mapping[str, YamlEntry] | None:
    """The entries of a mapping with known keys; None and an error if one is missing.

    `subject` is what it describes, for messages.
    """
    if not isinstance(value, YamlMap):
        hint = f"write {quoted(required or optional)} with their values below it"
        message = f"{subject} is a mapping, not {describe(value)}"
        diagnostics.error(rules.VALUE, value.location, message, hint)
        return None
    known = (*required, *optional)
    for key in [key for key in value.entries if key not in known]:
        message = f"{subject} has no key `{key}`"
        at = value.entries[key].location
        diagnostics.error(rules.UNKNOWN_KEY, at, message, suggest(key, known))
    missing = [key for key in required if key not in value.entries]
    if missing:
        message = f"{subject} lacks {quoted(missing)}"
        diagnostics.error(rules.MISSING_KEY, value.location, message, f"add {quoted(missing)}")
    return None if missing else value.entries


def entries_below(
    entry: YamlEntry | None, says: str, hint: str, diagnostics: Diagnostics
) -> Mapping[str, YamlEntry] | None:
    """The entries below a key, none if it is empty; None and an error if it has something else.

    `says` is what the error says, before what it has.
    """
    if entry is None or (isinstance(entry.value, YamlScalar) and entry.value.value is None):
        return {}
    if isinstance(entry.value, YamlMap):
        return entry.value.entries
    message = f"{says}, not {describe(entry.value)}"
    diagnostics.error(rules.VALUE, entry.value.location, message, hint)
    return None


def named_entries(
    entry: YamlEntry | None, section: str, diagnostics: Diagnostics
) -> Iterator[tuple[str, Location, YamlValue]]:
    """Name, location and value of each entry of a section; an empty section has none."""
    says, hint = f"`{section}` is a mapping of names", f"indent `name: ...` below `{section}:`"
    for name, named in (entries_below(entry, says, hint, diagnostics) or {}).items():
        if WORD.fullmatch(name):
            yield name, named.location, named.value
        else:
            message = f"`{name}` cannot be a name in `{section}`"
            diagnostics.error(rules.NAMING, named.location, message, NAMING_HINT)


def called(key: str, words: Collection[str]) -> str:
    """What a key may have been meant for among the words that can stand there."""
    meant = _OTHER_NAMES.get(key.lower(), "")
    word = meant.strip("`")
    hint = Hint(f"write {meant}", key, word if word in words else "")
    return hint if meant else suggest(key, words)


def usage(leaf: LeafType, named: Mapping[str, NamedValue]) -> str:
    """How a leaf is written with what it requires, and the names that fit."""
    if leaf.names_keys:
        return f"write `{leaf.key}: {{key: value}}`"
    required = [parameter for parameter in leaf.described if parameter.required]
    if not required:
        return f"write `{leaf.key}` alone, or its parameters by name"
    example = ", ".join(f"{parameter.name}: ..." for parameter in required)
    types = tuple(one for parameter in required for one in parameter.type.named_types)
    fitting = [name for name, value in named.items() if isinstance(value, types)]
    known = f" (known: {quoted(sorted(fitting))})" if fitting else ""
    return f"write `{leaf.key}: {{{example}}}`{known}"


def counted_hint(counts: str) -> str:
    """How a leaf is asked that writes its answer to a key."""
    return f"let it write `{counts}: n`, and ask `compare: {{value: $n, equals: 0}}` after it"


def likely(place: NamedValue | None, leaf: LeafType, given: Collection[str]) -> list[str]:
    """The parameters not given yet that need a value; of a place, else those for little else."""
    fitting = [
        one
        for one in leaf.described
        if one.name not in given and (not place or isinstance(place, one.type.named_types))
    ]
    needed = [one.name for one in fitting if one.required]
    if needed or not place:
        return needed
    narrow = min((len(one.type.types) for one in fitting), default=0)
    return [one.name for one in fitting if len(one.type.types) == narrow]


def parameter_hint(
    key: str, place: NamedValue | None, leaf: LeafType, given: Collection[str]
) -> str:
    """Which parameter an unknown one was meant for, whose value may be the name of a place.

    That is told by what lacks a value, by the kind of the place, and by the spelling.
    """
    if key in MODIFIERS:
        return f"`{key}` belongs beside `{leaf.key}`, not below it"
    free = [one.name for one in leaf.described if one.name not in given]
    unknown = set(given).difference(one.name for one in leaf.described)
    fitting = likely(place, leaf, given)
    if near := nearest(key, (place and fitting) or free):
        return near
    if len(fitting) == 1 and (place or len(unknown) == 1):
        return Hint(f"did you mean `{fitting[0]}`?", key, fitting[0] * (key not in _OTHER_SENSE))
    if key == NAME:
        return f"`{key}` belongs beside `{leaf.key}`, not below it"
    return suggest(key, free) if free else "it takes no more: remove it"
