"""The leaves that a task file may use, and what may be said about each.

A leaf class needs no registration beyond its constructor: keyword-only parameters give names,
types and defaults, the docstring of the class their descriptions.
"""

from __future__ import annotations

import inspect
import re
import typing
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib import metadata
from typing import TYPE_CHECKING

from trees.language.values import ValueType, read_annotation
from trees.language.vocabulary import RESERVED

if TYPE_CHECKING:
    from behaviours.leaf import Leaf

ENTRY_POINTS = "frankie_task.behaviours"
"""Entry-point group in which other packages offer their leaves."""


class LeafError(Exception):
    """A leaf class cannot be used in task files; the text says which and what to change."""


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a leaf."""

    name: str
    type: ValueType
    required: bool
    default: object = None
    """What it is if the file does not say; no meaning if `required`."""
    description: str = ""


@dataclass(frozen=True, kw_only=True)
class LeafType:
    """A leaf as a task file sees it."""

    key: str
    behaviour: type[Leaf]
    description: str
    parameters: Mapping[str, Parameter]


def known_leaves() -> dict[str, type[Leaf]]:
    """The project's own leaves and those that installed packages offer.

    Raises:
        LeafError: a package's leaf cannot be loaded, or takes a key that is taken.
    """
    from behaviours import LEAVES

    leaves = dict(LEAVES)
    for entry in metadata.entry_points(group=ENTRY_POINTS):
        try:
            leaf: type[Leaf] = entry.load()
            key = leaf.key
        except Exception as error:
            what = f"behaviour `{entry.name}` of `{entry.value}` cannot be loaded: {error}"
            raise LeafError(f"{what}; mend or uninstall its package") from error
        if key in leaves:
            raise LeafError(f"`{entry.value}` takes the key `{key}`, which is taken; rename it")
        leaves[key] = leaf
    return leaves


def describe_leaves(leaves: Mapping[str, type[Leaf]]) -> dict[str, LeafType]:
    """What task files may say about each leaf, by key.

    Raises:
        LeafError: a class does not keep to the contract of a leaf.
    """
    return {key: _describe(key, leaf) for key, leaf in leaves.items()}


def _describe(key: str, leaf: type[Leaf]) -> LeafType:
    if key in RESERVED:
        raise LeafError(f"leaf `{leaf.__name__}`: `{key}` is a word of the language; rename it")
    docstring = inspect.cleandoc(leaf.__doc__ or "")
    return LeafType(
        key=key,
        behaviour=leaf,
        description=" ".join(docstring.split("\n\n")[0].split()),
        parameters={
            parameter.name: parameter
            for parameter in _parameters(key, leaf.__init__, _argument_texts(docstring))
        },
    )


def _parameters(
    key: str, constructor: typing.Callable[..., None], texts: Mapping[str, str]
) -> Iterable[Parameter]:
    declared = [
        parameter
        for parameter in inspect.signature(constructor).parameters.values()
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY
    ]
    # Only these are evaluated: other annotations may name what is imported for checkers alone.
    carrier = type("Annotated", (), {})
    carrier.__annotations__ = {parameter.name: parameter.annotation for parameter in declared}
    names = getattr(constructor, "__globals__", {})
    try:
        hints = typing.get_type_hints(carrier, globalns=names)
        for parameter in declared:
            required = parameter.default is inspect.Parameter.empty
            yield Parameter(
                name=parameter.name,
                type=read_annotation(hints[parameter.name]),
                required=required,
                default=None if required else parameter.default,
                description=texts.get(parameter.name, ""),
            )
    except (NameError, TypeError) as error:
        mend = "use float, int, bool, str, Literal, poses, postures, regions or their unions"
        raise LeafError(f"leaf `{key}`: {error}; {mend}") from error


def _argument_texts(docstring: str) -> dict[str, str]:
    """The descriptions in the `Args:` section of a Google-style docstring."""
    section = re.search(r"^Args:\n((?:[ \t]+.*\n?|\n)*)", docstring, re.MULTILINE)
    if section is None:
        return {}
    body = inspect.cleandoc(section[1])
    entries = re.findall(r"^(\w+)[^:\n]*:((?:.*)(?:\n[ \t]+.*)*)", body, re.MULTILINE)
    return {name: " ".join(text.split()).rstrip(".") for name, text in entries}
