"""YAML 1.2 and configuration files: what a model gets, and what a person is told, all at once."""

import math
from pathlib import Path
from typing import Annotated, Literal

import pytest
import yaml
from pydantic import Field, field_validator

from config import Diagnostics, parse_scalar, parse_yaml
from config.reader import ConfigError, StrictModel, read_config

MISTAKES = yaml.safe_load(Path(__file__).with_name("mistakes.yaml").read_text("utf-8"))


class Wheel(StrictModel):
    radius_m: Annotated[float, Field(gt=0.0)]
    side: Literal["left", "right"] = "left"


class Cart(StrictModel):
    name: str
    wheels: tuple[Wheel, ...] = ()
    spare: Wheel | None = None
    size: tuple[float, float] = (1.0, 1.0)
    load: list[float] = Field(default=[0.0, 0.0], min_length=2, max_length=2)
    is_electric: bool = False
    seats: int = 0

    @field_validator("name")
    @classmethod
    def _short(cls, name: str) -> str:
        if len(name) > 8:
            raise ValueError("is too long; write at most 8 letters")
        return name


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "cart.yaml"


def test_a_file_becomes_a_model(path):
    path.write_text(
        "name: no\nwheels:\n- {radius_m: 1e-1}\n- {radius_m: 2, side: right}\nsize: [1, 2.5]\n"
        "spare: null\nis_electric: true\nseats: 0x10\n"
    )
    cart = read_config(path, Cart)
    assert cart.name == "no"
    assert [(wheel.radius_m, wheel.side) for wheel in cart.wheels] == [(0.1, "left"), (2, "right")]
    assert (cart.size, cart.spare, cart.is_electric, cart.seats) == ((1.0, 2.5), None, True, 16)


@pytest.mark.parametrize("row", MISTAKES["carts"], ids=lambda row: row["text"])
def test_an_error_has_a_location_and_a_hint(path, row):
    path.write_text(row["text"] + "\n")
    with pytest.raises(ConfigError) as raised:
        read_config(path, Cart)
    [line] = str(raised.value).splitlines()
    assert line.startswith(f"{path}:{row['tells']}")


def test_all_errors_of_a_file_come_at_once_in_its_order(path):
    path.write_text("seats: many\nwheels: [{radius_m: -1}, 3]\nspare: {}\ncolour: red\n")
    with pytest.raises(ConfigError) as raised:
        read_config(path, Cart)
    lines = [line.removeprefix(f"{path}:") for line in str(raised.value).splitlines()]
    assert [line.split(": ")[:2] for line in lines] == [
        ["1:1", "name"],
        ["1:8", "seats"],
        ["2:21", "wheels.0.radius_m"],
        ["2:26", "wheels.1"],
        ["3:1", "spare.radius_m"],
        ["4:1", "colour"],
    ]


def test_a_missing_file_is_an_error_of_the_user(tmp_path):
    with pytest.raises(ConfigError, match=r"none.yaml: there is no such file; check the path"):
        read_config(tmp_path / "none.yaml", Cart)


@pytest.mark.parametrize(
    ("text", "meaning"),
    [
        ("no", "no"),
        ("true", True),
        ("null", None),
        ("", None),
        ("1", 1),
        ("010", 10),
        ("0x1F", 31),
        ("1e-3", 0.001),
        ("1.", 1.0),
        ("-.inf", -math.inf),
        ("1_000", "1_000"),
        ("9" * 5000, math.inf),
        ("٣", "٣"),
    ],
)
def test_plain_scalars_follow_yaml_1_2(text, meaning):
    assert parse_scalar(text) == meaning
    assert type(parse_scalar(text)) is type(meaning)


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
