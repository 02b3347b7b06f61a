"""YAML 1.2 core scalars, and texts that are no YAML."""

import math
from pathlib import Path

import pytest
import yaml

from config import Diagnostics, parse_scalar, parse_yaml

MISTAKES = yaml.safe_load(Path(__file__).with_name("mistakes.yaml").read_text("utf-8"))


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


@pytest.mark.parametrize("row", MISTAKES["yaml"], ids=lambda row: row["tells"])
def test_texts_that_are_refused(row):
    text = row["text"].replace("DEEP", "[" * 70)
    diagnostics = Diagnostics(Path("x"))
    parse_yaml(text, diagnostics)
    [diagnostic] = diagnostics.in_order()
    assert str(diagnostic).startswith(row["tells"])
