"""YAML 1.2 core scalars, and texts that are no YAML."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from config import Diagnostics, parse_scalar, parse_yaml


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("no", "no"),
        ("true", True),
        ("False", False),
        ("null", None),
        ("", None),
        ("1", 1),
        ("010", 10),
        ("0o10", 8),
        ("0x1F", 31),
        ("1e-3", 0.001),
        ("1.", 1.0),
        ("-.inf", -math.inf),
        ("1_000", "1_000"),
        ("2024-01-01", "2024-01-01"),
        ("9" * 5000, math.inf),
        ("٣", "٣"),
    ],
)
def test_plain_scalars_follow_yaml_1_2(text, meaning):
    assert parse_scalar(text) == meaning
    assert type(parse_scalar(text)) is type(meaning)


def test_nan_is_a_number():
    assert math.isnan(parse_scalar(".nan"))


def test_quotes_make_text():
    document = parse_yaml("['1', \"no\", 1]", Diagnostics(Path("x")))
    assert [item.value for item in document.items] == ["1", "no", 1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "x:1:1: the file is empty; write its keys and their values"),
        ("a: 1\nb: 2\na: 3", "x:3:1: the key `a` appears twice, first on line 1; keep one of them"),
        ("a: &x 1", "x:1:4: anchors and aliases are not supported; write the value out"),
        ("a: !!int 1", "x:1:4: the tag 'tag:yaml.org,2002:int' is not supported; remove it"),
        ("a: 1\n---\nb: 2", "x:2:1: a second document starts here; keep one document per file"),
        (
            "a:\n\t- b",
            "x:2:1: this is not YAML: found character '\\t' that cannot start any token;",
        ),
        ("a: b: c", "x:1:5: this is not YAML: mapping values are not allowed here; check the"),
        ('a: "\\UFFFFFFFF"', "x:1:7: this is not YAML: a number or an escape is out of range;"),
        ("a: 1\nb: \x07", "x:2:4: this is not YAML: character '\\x07' is not allowed; remove it"),
        ("1: a", "x:1:1: this key is not a word; give it a name, or write it in quotes"),
        ("a: " + "[" * 70, "x:1:67: this is not YAML: it nests deeper than 64 levels; split it"),
    ],
)
def test_texts_that_are_refused(text, message):
    diagnostics = Diagnostics(Path("x"))
    parse_yaml(text, diagnostics)
    [diagnostic] = diagnostics.in_order()
    assert str(diagnostic).startswith(message)
