"""The ports of a tree in the XML as the sections of a task file: parameters, poses, regions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from config import suggest
from trees.btcpp.elements import Element
from trees.btcpp.places import read_place_text
from trees.btcpp.ports import read_literal
from trees.btcpp.words import PORT_TYPES
from trees.language.diagnostics import Diagnostics, Location
from trees.language.source import plain
from trees.language.value_types import PARAMETER_TYPES, ValueType, type_of

_WORDS: Mapping[str, str] = {port: word for word, port in PORT_TYPES.items()}


NOWHERE: Mapping[str, Location] = MappingProxyType({})


class Located(dict[str, Any]):
    """A mapping of a task file that knows which place of the XML it comes from.

    Args:
        place: in the XML.
        said: keys and values.
    """

    def __init__(self, place: Location, said: Mapping[str, Any]) -> None:
        super().__init__(said)
        self.place = place


class Item(Located):
    """A node of the tree, with what stands beside its key.

    Args:
        place: of the node in the XML.
        said: keys and values.
        modifiers: where each of its modifiers is in the XML.
    """

    def __init__(
        self, place: Location, said: Mapping[str, Any], modifiers: Mapping[str, Location] = NOWHERE
    ) -> None:
        super().__init__(place, said)
        self.modifiers = modifiers


@dataclass(frozen=True, kw_only=True)
class Sections:
    """What a tree's ports become; empty if it has none."""

    params: dict[str, Located] = field(default_factory=dict)
    poses: dict[str, Located] = field(default_factory=dict)
    regions: dict[str, Located] = field(default_factory=dict)
    outputs: dict[str, str] = field(default_factory=dict)
    types: dict[str, ValueType | None] = field(default_factory=dict)
    """Of the parameters; None if it is only known by its default."""

    def is_place(self, name: str) -> bool:
        """Whether a pose or region goes by this name."""
        return name in self.poses or name in self.regions


def read_sections(model: Element | None, diagnostics: Diagnostics) -> Sections:
    """The sections of the tree that a `<SubTree>` of the models is about."""
    sections = Sections()
    for port in [] if model is None else model.children:
        name = port.attributes.get("name", "")
        if port.tag == "output_port":
            sections.outputs[name] = port.text
        elif port.tag != "input_port":
            what = f"a port `<{port.tag}>` of a tree has no counterpart"
            diagnostics.error(port.place, what, "make it an input or an output")
        elif (fields := read_place_text(port.attributes.get("default", ""))) is not None:
            numbers = {key: [plain(number) for number in text] for key, text in fields.items()}
            said = {key: one[0] if len(one) == 1 else one for key, one in numbers.items()}
            section = sections.regions if "centre" in said else sections.poses
            section[name] = Located(port.place, said)
        else:
            sections.params[name], sections.types[name] = _parameter(port, diagnostics)
    return sections


def _parameter(port: Element, diagnostics: Diagnostics) -> tuple[Located, ValueType | None]:
    """What the section `params` says about a port, and its type."""
    given = port.attributes
    said: dict[str, Any] = {}
    expected: ValueType | None = None
    if "_choices" in given:
        choices = tuple(plain(choice) for choice in given["_choices"].split(";"))
        said["type"], expected = list(choices), ValueType(kinds=(), choices=choices)
    elif (word := _WORDS.get(given.get("type", ""))) is not None:
        said["type"], expected = word, PARAMETER_TYPES[word]
    elif "type" in given and given["type"] != "BT::AnyTypeAllowed":
        what = f"the port type `{given['type']}` has no counterpart"
        diagnostics.error(port.place, what, suggest(given["type"], _WORDS))
    if "default" in given:
        said["default"] = read_literal(given["default"], expected)
        if expected == type_of(said["default"]):
            del said["type"]
    for key in ("min", "max"):
        if f"_{key}" in given:
            said[key] = plain(given[f"_{key}"])
    if port.text:
        said["description"] = port.text
    return Located(port.place, said), expected
