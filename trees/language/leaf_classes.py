"""Descriptions of leaves, read from their classes.

Keyword-only parameters of the constructor give names, types and defaults, the docstring of the
class their descriptions. Those annotated `Key[T]` are outputs.
"""

from __future__ import annotations

import inspect
import re
import types
import typing
from collections.abc import Iterable, Mapping
from functools import cache

from behaviours import Condition, Key, Leaf
from trees.language.leaf_type import OWN_LEAVES, LeafError, LeafType, Output, Parameter
from trees.language.mappings import NAMING_HINT, WORD
from trees.words import RESERVED, ValueType, read_annotation


def describe_leaves(leaves: Mapping[str, type[Leaf]]) -> dict[str, LeafType]:
    """What task files may give to each leaf, by key; `set` and `add` are always among them.

    Raises LeafError: a class does not keep to the contract of a leaf.
    """
    return dict(OWN_LEAVES) | {key: _describe(key, leaf) for key, leaf in leaves.items()}


_SAID = (
    *("goes_to", "surfaces", "comparable", "hand_before", "hand_after", "opens_for", "lasts"),
    *("base_rests", "near_furniture", "counts", "can_fail", "moves", "needs_robot"),
)
"""What the class itself says; toys say less."""


@cache
def _describe(key: str, leaf: type[Leaf]) -> LeafType:
    if not isinstance(key, str) or not WORD.fullmatch(key):
        raise LeafError(f"leaf `{leaf.__name__}`: its key is no word; {NAMING_HINT}")
    if key in (*RESERVED, *OWN_LEAVES):
        raise LeafError(f"leaf `{leaf.__name__}`: `{key}` is a word of the language; rename it")
    docstring = inspect.cleandoc(leaf.__doc__ or "")
    description, _, details = docstring.partition("\nArgs:\n")[0].partition("\n\n")
    described = list(_parameters(key, leaf.__init__, _argument_texts(docstring)))
    validate = getattr(leaf, "validate", None)
    return LeafType(
        key=key,
        behaviour=leaf,
        description=" ".join(description.split()),
        details=" ".join(details.split()),
        parameters={one.name: one for one in described if not isinstance(one, Output)},
        outputs={one.name: one for one in described if isinstance(one, Output)},
        **{name: getattr(leaf, name) for name in _SAID if hasattr(leaf, name)},
        validate=None if validate is Leaf.validate else validate,
        is_condition=issubclass(leaf, Condition),
        takes_time=not issubclass(leaf, Condition),
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


def _parameter(declared: inspect.Parameter, hint: object, text: str) -> Parameter:
    required, output_type = declared.default is inspect.Parameter.empty, _output_type(hint)
    return (Parameter if output_type is None else Output)(
        name=declared.name,
        type=output_type or read_annotation(hint),
        required=required,
        default=None if required else declared.default,
        description=text,
        unit=_unit(text),
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


def _unit(text: str) -> str:
    """The unit that stands in brackets in a description; empty if there is none."""
    unit = re.search(r"\[([^\]]+)\]", text)
    return unit[1].replace("^2", "²").replace("deg", "°") if unit else ""


def _argument_texts(docstring: str) -> dict[str, str]:
    """The descriptions in the `Args:` section of a Google-style docstring."""
    section = re.search(r"^Args:\n((?:[ \t]+.*\n?|\n)*)", docstring, re.MULTILINE)
    if section is None:
        return {}
    body = inspect.cleandoc(section[1])
    entries = re.findall(r"^(\w+)[^:\n]*:((?:.*)(?:\n[ \t]+.*)*)", body, re.MULTILINE)
    return {name: " ".join(text.split()).rstrip(".") for name, text in entries}
