"""What the registry reads from the classes of leaves."""

from typing import Annotated

import pytest
from py_trees.common import Status
from tree_toys import TOYS, Toy, ToyContext

from behaviours import Bounds, Key, Positive
from trees.language import LeafError, build, describe_leaves, load


class Measure(Toy):
    """Look at something
    for a while.

    It takes its time, and
    says what it saw.

    Then it ends.

    Args:
        lock_distance_m: how near [m].
        speed_m_s: how fast [m/s].
        turn_deg: how far [deg].
        area: how large [cm^2].
        times: how often.
        mean_s: how long on average [s].
    """

    def __init__(
        self,
        name: str,
        context: object,
        *,
        lock_distance_m: float,
        speed_m_s: float = 1.0,
        turn_deg: float = 0.0,
        area: float = 1.0,
        times: int = 1,
        mean_s: Key[float],
        found: Key[int | str] | None = None,
    ) -> None: ...


def test_a_leaf_is_described_by_its_constructor_and_docstring():
    measure = describe_leaves({"measure": Measure})["measure"]
    assert measure.description == "Look at something for a while."
    assert measure.details == "It takes its time, and says what it saw. Then it ends."
    assert not measure.is_condition
    assert {name: parameter.unit for name, parameter in measure.parameters.items()} == {
        "lock_distance_m": "m",
        "speed_m_s": "m/s",
        "turn_deg": "°",
        "area": "cm²",
        "times": "",
    }
    assert measure.parameters["lock_distance_m"].required
    assert measure.parameters["speed_m_s"].default == 1.0
    outputs = [(one.name, str(one.type), one.required) for one in measure.outputs.values()]
    assert outputs == [("mean_s", "a number", True), ("found", "a whole number or text", False)]
    mean = measure.outputs["mean_s"]
    assert (mean.unit, mean.description) == ("s", "how long on average [s]")


def test_a_word_of_the_language_is_no_key_of_a_leaf():
    with pytest.raises(LeafError, match="`sequence` is a word of the language"):
        describe_leaves({"sequence": Toy})


def test_an_output_that_no_file_can_take_is_refused():
    class Odd(Toy):
        def __init__(self, name: str, context: object, *, where: Key[dict]) -> None: ...

    with pytest.raises(
        LeafError, match=r"^leaf `odd`, parameter `where` of .*dict.*; use float, int, bool"
    ):
        describe_leaves({"odd": Odd})


class Bounded(Toy):
    def __init__(
        self,
        name: str,
        context: object,
        *,
        speed: Positive = 1.0,
        times: Annotated[int, Bounds(least=2, most=4)] | None = None,
    ) -> None:
        super().__init__(name, context)


@pytest.mark.parametrize(("value", "status"), [("2.0", Status.SUCCESS), ("-2.0", Status.FAILURE)])
def test_a_number_from_a_key_is_checked_when_it_is_known(tmp_path, value, status):
    path = tmp_path / "t.yaml"
    path.write_text(f"task: t\ntree:\n  sequence: [set: {{v: {value}}}, bounded: {{speed: $v}}]\n")
    root = build(load(path, leaves=TOYS | {"bounded": Bounded}), ToyContext())
    root.tick_once()
    assert root.status is status
    if status is Status.FAILURE:
        expected = "refuses its parameters: `speed`: expected a number greater than 0, got -2.0"
        assert expected in root.feedback_message
