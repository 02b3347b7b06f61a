"""Task files that the program writes: the text, and where each part of it comes from."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from trees.btcpp.sections import NOWHERE, Item, Located
from trees.language.diagnostics import Diagnostics, Location
from trees.language.source import Items, Table, Value, compose, plain
from trees.language.vocabulary import MODIFIERS, NAME

_APART = ("params", "outputs", "poses", "regions", "tree")
"""Sections that begin after an empty line."""


_BOOL = "tag:yaml.org,2002:bool"


class _Bare(str):
    """A leaf without parameters, written as its key alone."""

    place: Location


class _Dumper(yaml.SafeDumper):
    """Quotes what the language would read as anything but text, and no more: `on` is a word."""


def _text(dumper: _Dumper, text: str) -> yaml.Node:
    style = None if plain(text) == text else "'"
    return dumper.represent_scalar("tag:yaml.org,2002:str", str(text), style=style)


def _number(dumper: _Dumper, number: float) -> yaml.Node:
    return dumper.represent_scalar("tag:yaml.org,2002:float", repr(number))


def _mapping(dumper: _Dumper, said: dict[str, Any]) -> yaml.Node:
    flow = False if isinstance(said, Item) else None
    return dumper.represent_mapping("tag:yaml.org,2002:map", said.items(), flow_style=flow)


_Dumper.yaml_implicit_resolvers = {
    first: [resolver for resolver in resolvers if resolver[0] != _BOOL]
    for first, resolvers in yaml.SafeDumper.yaml_implicit_resolvers.items()
}
_Dumper.add_implicit_resolver(_BOOL, re.compile("true|false"), ["t", "f"])
_Dumper.add_multi_representer(str, _text)
_Dumper.add_representer(str, _text)
_Dumper.add_representer(float, _number)
_Dumper.add_multi_representer(dict, _mapping)


def yaml_text(said: Located) -> str:
    """A task file that says this, each node as a person would write it."""
    text: str = yaml.dump(
        Located(said.place, {**said, "tree": _arranged(said["tree"])}),
        Dumper=_Dumper,
        default_flow_style=None,
        sort_keys=False,
        allow_unicode=True,
        width=100,
    )
    return re.sub(rf"^({'|'.join(_APART)}):", r"\n\1:", text, flags=re.MULTILINE)


def traced(place: Location | None, text: str, said: Located) -> Location:
    """The place in the XML that a place in a written task file comes from."""
    value = compose(text, Diagnostics(Path()))
    sections = Located(said.place, {**said, "tree": _arranged(said["tree"])})
    found = dict(_traces(value, sections, said.place))
    return said.place if place is None else found.get(place, said.place)


def _arranged(said: Any) -> Any:
    """The same, every node with its name and modifiers before its key, or as its bare key."""
    if isinstance(said, list):
        return [_arranged(one) for one in said]
    if not isinstance(said, Located):
        return said
    keys = list(said)
    if isinstance(said, Item):
        if len(said) == 1 and said[keys[0]] is None:
            bare = _Bare(keys[0])
            bare.place = said.place
            return bare
        beside = {key: position for position, key in enumerate((NAME, *MODIFIERS))}
        keys.sort(key=lambda key: beside.get(key, len(beside)))
    arranged = {key: _arranged(said[key]) for key in keys}
    if isinstance(said, Item):
        return Item(said.place, arranged, said.modifiers)
    return Located(said.place, arranged)


def _traces(value: Value | None, said: Any, place: Location) -> Iterator[tuple[Location, Location]]:
    """Places in the text and in the XML, of a value and of all in it."""
    place = getattr(said, "place", place)
    if value is None:
        return
    yield value.place, place
    if isinstance(value, Table) and isinstance(said, Mapping):
        beside = said.modifiers if isinstance(said, Item) else NOWHERE
        for key, entry in value.entries.items():
            inner: Location = beside.get(key, getattr(said[key], "place", place))
            yield entry.place, inner
            yield from _traces(entry.value, said[key], inner)
    elif isinstance(value, Items) and isinstance(said, list):
        for item, one in zip(value.items, said, strict=True):
            yield from _traces(item, one, place)
