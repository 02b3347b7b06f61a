"""The leaves that a task file may use, and what it may give to each.

A leaf class needs no registration beyond its constructor: keyword-only parameters give names,
types and defaults, the docstring of the class their descriptions. Those annotated `Key[T]` are its
outputs.
"""

from __future__ import annotations

import inspect
import re
import types
import typing
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING

from behaviours import LEAVES, Condition, Key, Leaf
from config import entries
from trees.language.errors import LeafError
from trees.language.keys import Add, Set
from trees.language.mappings import NAMING_HINT, WORD
from trees.language.plugins import ENTRY_POINTS, Offer, offer_of
from trees.language.value_types import ValueType, read_annotation
from trees.language.vocabulary import RESERVED

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a leaf."""

    name: str
    type: ValueType
    required: bool
    default: object = None
    """Its value if the file gives none; no meaning if `required`."""
    description: str = ""
    unit: str = ""
    """`m/s`, `s`, ...; empty if it has none."""


@dataclass(frozen=True, kw_only=True)
class Output:
    """A result of a leaf; a task file names the key that it is written to."""

    name: str
    type: ValueType
    required: bool
    """Whether the file has to name a key."""
    description: str = ""
    unit: str = ""


@dataclass(frozen=True, kw_only=True)
class LeafType:
    """A leaf as a task file sees it."""

    key: str
    behaviour: Callable[..., Behaviour]
    description: str
    """The first paragraph of its docstring."""
    details: str = ""
    """The paragraphs after that."""
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    outputs: Mapping[str, Output] = field(default_factory=dict)
    goes_to: tuple[str, ...] = ()
    """Its parameters that name where the robot has to get."""
    surfaces: tuple[str, ...] = ()
    """Its parameters that name a region with a surface below."""
    alike: tuple[str, ...] = ()
    """Its parameters that have values of one kind."""
    lasts: str = ""
    """Its parameter that says how long it takes at least; empty if none does."""
    moves: bool = False
    """Whether it may move the robot."""
    needs_robot: bool = True
    """Whether it needs more than its arguments, the time and the log."""
    names_keys: bool = False
    """Whether its arguments have the names of keys, which it writes."""
    is_condition: bool
    takes_time: bool
    """Whether it may run for more than a tick."""
    can_fail: bool

    @property
    def described(self) -> tuple[Parameter | Output, ...]:
        """Its parameters and outputs."""
        return *self.parameters.values(), *self.outputs.values()


SET = LeafType(
    key="set",
    behaviour=Set,
    description="Writes values to keys: `set: {tries: 0}`; ends at once and cannot fail.",
    names_keys=True,
    is_condition=False,
    takes_time=False,
    can_fail=False,
)
"""Writes keys: its arguments have their names."""

ADD = LeafType(
    key="add",
    behaviour=Add,
    description="Adds numbers to keys: `add: {tries: 1}`; ends at once and cannot fail.",
    names_keys=True,
    is_condition=False,
    takes_time=False,
    can_fail=False,
)
"""Counts: its arguments have the names of the keys."""

OWN_LEAVES: Mapping[str, LeafType] = {leaf.key: leaf for leaf in (SET, ADD)}
"""The leaves that are words of the language."""


class Installed:
    """The leaves of this installation; a package is imported only when one of its leaves is wanted.

    Args:
        leaves: what there is besides packages; None is the project's own leaves, and packages.
    """

    def __init__(self, leaves: Mapping[str, type[Leaf]] | None = None) -> None:
        self._pending = entries(ENTRY_POINTS) if leaves is None else []
        self._classes = dict(LEAVES if leaves is None else leaves)
        self.leaves = describe_leaves(self._classes)
        """By their keys: those of packages are added when they are fetched."""
        self.problems: dict[str, str] = {}
        """Of packages that cannot be used, in a line each, by the name of the entry point."""
        _found_problems.clear()

    def fetch(self, name: str | None = None) -> None:
        """Import what packages offer by this name, or all that they offer."""
        wanted = [entry for entry in self._pending if name in (None, entry.name)]
        for entry in wanted:
            self._pending.remove(entry)
            usable = _checked(offer_of(entry), self._classes)
            if usable.leaf is None:
                self.problems[usable.name] = usable.problem
            else:
                self._classes[usable.leaf.key] = usable.leaf
                self.leaves[usable.leaf.key] = _describe(usable.leaf.key, usable.leaf)
        _found_problems.update(self.problems)

    @property
    def classes(self) -> dict[str, type[Leaf]]:
        """The classes of all leaves, by their keys."""
        self.fetch()
        return dict(self._classes)


_found_problems: dict[str, str] = {}


def plugin_problems() -> list[str]:
    """What is wrong with installed packages, as far as they were looked at: a line each."""
    return list(_found_problems.values())


def _checked(offer: Offer, taken: Iterable[str]) -> Offer:
    """The offer, with a problem if its leaf does not keep to the contract."""
    if offer.leaf is None:
        return offer
    try:
        if offer.leaf.key in taken:
            return offer.broken(f"it takes the key `{offer.leaf.key}`, which is taken")
        _describe(offer.leaf.key, offer.leaf)
    except Exception as error:  # of a class that anybody may have written
        return offer.broken(str(error) or type(error).__name__)
    return offer


def known_leaves() -> dict[str, type[Leaf]]:
    """The leaves that task files may use, by their keys: the project's own, and of packages."""
    return Installed().classes


def describe_leaves(leaves: Mapping[str, type[Leaf]]) -> dict[str, LeafType]:
    """What task files may give to each leaf, by key; `set` and `add` are always among them.

    Raises:
        LeafError: a class does not keep to the contract of a leaf.
    """
    return dict(OWN_LEAVES) | {key: _describe(key, leaf) for key, leaf in leaves.items()}


@cache
def _describe(key: str, leaf: type[Leaf]) -> LeafType:
    if not isinstance(key, str) or not WORD.fullmatch(key):
        raise LeafError(f"leaf `{leaf.__name__}`: its key is no word; {NAMING_HINT}")
    if key in (*RESERVED, *OWN_LEAVES):
        raise LeafError(f"leaf `{leaf.__name__}`: `{key}` is a word of the language; rename it")
    docstring = inspect.cleandoc(leaf.__doc__ or "")
    description, _, details = docstring.partition("\nArgs:\n")[0].partition("\n\n")
    described = list(_parameters(key, leaf.__init__, _argument_texts(docstring)))
    return LeafType(
        key=key,
        behaviour=leaf,
        description=" ".join(description.split()),
        details=" ".join(details.split()),
        parameters={one.name: one for one in described if isinstance(one, Parameter)},
        outputs={one.name: one for one in described if isinstance(one, Output)},
        goes_to=getattr(leaf, "goes_to", ()),
        surfaces=getattr(leaf, "surfaces", ()),
        alike=getattr(leaf, "alike", ()),
        lasts=getattr(leaf, "lasts", ""),
        moves=getattr(leaf, "moves", False),
        needs_robot=getattr(leaf, "needs_robot", True),
        is_condition=issubclass(leaf, Condition),
        takes_time=not issubclass(leaf, Condition),
        can_fail=True,
    )


def _parameters(
    key: str, constructor: typing.Callable[..., None], texts: Mapping[str, str]
) -> Iterable[Parameter | Output]:
    declared = [
        parameter
        for parameter in inspect.signature(constructor).parameters.values()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    ]
    # Only these are evaluated: other annotations may name what is imported for checkers alone.
    names = getattr(constructor, "__globals__", {})
    for parameter in declared:
        carrier = type("Annotated", (), {})
        carrier.__annotations__ = {parameter.name: parameter.annotation}
        try:
            hints = typing.get_type_hints(carrier, globalns=names, include_extras=True)
            yield _parameter(parameter, hints[parameter.name], texts.get(parameter.name, ""))
        except (NameError, TypeError) as error:
            hint = "use float, int, bool, str, Literal, poses, regions, their unions or a Key"
            whose = f"leaf `{key}`, parameter `{parameter.name}` of {constructor.__qualname__}"
            raise LeafError(f"{whose}: {error}; {hint}") from error


def _parameter(declared: inspect.Parameter, hint: object, text: str) -> Parameter | Output:
    name, required = declared.name, declared.default is inspect.Parameter.empty
    unit = _unit(name, text)
    output_type = _output_type(hint)
    if output_type is not None:
        return Output(name=name, type=output_type, required=required, description=text, unit=unit)
    return Parameter(
        name=name,
        type=read_annotation(hint),
        required=required,
        default=None if required else declared.default,
        description=text,
        unit=unit,
    )


def _output_type(hint: object) -> ValueType | None:
    """T of `Key[T]` or `Key[T] | None`; None for other annotations."""
    is_union = typing.get_origin(hint) in (typing.Union, types.UnionType)
    parts = [part for part in typing.get_args(hint) if part is not types.NoneType]
    if is_union and len(parts) == 1:
        hint = parts[0]
    if typing.get_origin(hint) is not Key:
        return None
    return read_annotation(typing.get_args(hint)[0])


_UNITS: Mapping[str, str] = {
    "_m_s": "m/s",
    "_deg_s": "°/s",
    "_cm2": "cm²",
    "_mm": "mm",
    "_deg": "°",
    "_m": "m",
    "_s": "s",
    "_n": "N",
    "percent": "%",
}
"""By the end of a parameter's name; the first that fits."""


def _unit(name: str, text: str) -> str:
    """The unit that the end of the description gives in brackets, or that of the name."""
    unit = re.search(r"\[([^\]]+)\]$", text)
    if unit:
        return unit[1].replace("^2", "²").replace("deg", "°")
    return next((unit for ending, unit in _UNITS.items() if name.endswith(ending)), "")


def _argument_texts(docstring: str) -> dict[str, str]:
    """The descriptions in the `Args:` section of a Google-style docstring."""
    section = re.search(r"^Args:\n((?:[ \t]+.*\n?|\n)*)", docstring, re.MULTILINE)
    if section is None:
        return {}
    body = inspect.cleandoc(section[1])
    entries = re.findall(r"^(\w+)[^:\n]*:((?:.*)(?:\n[ \t]+.*)*)", body, re.MULTILINE)
    return {name: " ".join(text.split()).rstrip(".") for name, text in entries}
