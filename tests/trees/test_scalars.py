"""YAML 1.2 core scalars, and texts that are no YAML."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from trees.language.diagnostics import Diagnostics
from trees.language.source import compose, plain


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("no", "no"),
        ("yes", "yes"),
        ("on", "on"),
        ("true", True),
        ("False", False),
        ("null", None),
        ("~", None),
        ("", None),
        ("1", 1),
        ("-17", -17),
        ("010", 10),
        ("0o10", 8),
        ("0x1F", 31),
        ("1e-3", 0.001),
        ("1e3", 1000.0),
        ("1.", 1.0),
        (".5", 0.5),
        ("-.inf", -math.inf),
        ("1_000", "1_000"),
        ("12:30:45", "12:30:45"),
        ("2024-01-01", "2024-01-01"),
        ("9" * 5000, math.inf),
        ("inf", "inf"),
        ("٣", "٣"),
    ],
)
def test_plain_scalars_follow_yaml_1_2(text, meaning):
    assert plain(text) == meaning
    assert type(plain(text)) is type(meaning)


def test_nan_is_a_number():
    assert math.isnan(plain(".nan"))


def test_quotes_make_text():
    document = compose("['1', \"no\", 1]", Diagnostics(Path("x")))
    assert [item.value for item in document.items] == ["1", "no", 1]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "x:1:1: the file is empty; write at least `task:` and `tree:`"),
        ("# only a comment\n", "x:1:1: the file is empty; write at least `task:` and `tree:`"),
        ("a: 1\nb: 2\na: 3", "x:3:1: the key `a` appears twice, first on line 1; keep one of them"),
        ("a: &x 1", "x:1:4: anchors and aliases are not part of a task file; write the value out"),
        ("a: !!int 1", "x:1:4: the tag 'tag:yaml.org,2002:int' is not part of a task file;"),
        ("a: 1\n---\nb: 2", "x:2:1: a second document starts here; keep one task a file"),
        (
            "a:\n\t- b",
            "x:2:1: this is not YAML: found character '\\t' that cannot start any token;",
        ),
        ("a: b: c", "x:1:5: this is not YAML: mapping values are not allowed here; check the"),
        ('a: "\\UFFFFFFFF"', "x:1:7: this is not YAML: a number or an escape is out of range;"),
        ("a: 1\nb: \x07", "x:2:4: character '\\x07' may not stand in YAML; remove it"),
        ("1: a", "x:1:1: this key is not a word; give it a name"),
        ("[a]: b", "x:1:1: this key is not a word; give it a name"),
        ("a: " + "[" * 70, "x:1:67: this is not YAML: it nests deeper than 64 levels; split it"),
    ],
)
def test_texts_that_are_refused(text, message):
    diagnostics = Diagnostics(Path("x"))
    compose(text, diagnostics)
    [diagnostic] = diagnostics.in_order()
    assert str(diagnostic).startswith(message)


def test_aliases_are_refused_where_they_stand():
    diagnostics = Diagnostics(Path("x"))
    compose("a: &x 1\nb: *x", diagnostics)
    assert [str(diagnostic).split(": ")[0] for diagnostic in diagnostics.in_order()] == [
        "x:1:4",
        "x:2:4",
    ]
