"""What the words say of their outcomes is how their nodes behave."""

import itertools
import random

import pytest
from py_trees.behaviour import Behaviour
from py_trees.common import Status
from tree_toys import ToyContext

from hw import TaskTime
from trees.language import ASKING, COMPOSITES, MODIFIERS, Form
from trees.words import Outcomes


class Dice(Behaviour):
    """Outcomes in one of some ways, and notes that it has."""

    def __init__(self, name: str, ways: list[Status], rng: random.Random, ended: list) -> None:
        super().__init__(name)
        self.ways, self.rng, self.ended = ways, rng, ended

    def update(self) -> Status:
        status = self.rng.choice([*self.ways, Status.RUNNING])
        if status is not Status.RUNNING:
            self.ended.append((self.name, status))
        return status


class HastyClock:
    """Every look at it takes three seconds."""

    def __init__(self) -> None:
        self._looks = itertools.count(step=3)

    def now(self) -> TaskTime:
        return TaskTime(float(next(self._looks)))


OTHERS = [word for key, word in MODIFIERS.items() if key != "force"]
POSSIBLE = {"S": [Status.SUCCESS], "F": [Status.FAILURE], "SF": [Status.SUCCESS, Status.FAILURE]}


def claimed(ways: str, name: str):
    """The ends of a child that can end in these ways and then has written a key, as followed."""

    def follow(before):
        if before is None:
            return Outcomes(None, None)
        return Outcomes(
            before | {f"{name} S"} if "S" in ways else None,
            before | {f"{name} F"} if "F" in ways else None,
        )

    return follow


def observe(make, count: int, ways: tuple[str, ...]) -> list[tuple[Status, set[str]]]:
    """How a branch has ended in some runs of two rounds, and what was written by then."""
    seen = []
    for run in range(30):
        ended: list = []
        rng = random.Random(run)
        children = [Dice(f"c{i}", POSSIBLE[ways[i]], rng, ended) for i in range(count)]
        branch = make(children)
        for _ in range(60):
            branch.tick_once()
            if branch.status is not Status.RUNNING:
                written = {f"{name} {'SF'[status is Status.FAILURE]}" for name, status in ended}
                seen.append((branch.status, written))
                if len(seen) % 2 == 0:
                    break
        branch.stop(Status.INVALID)
    return seen


def judge(ends: Outcomes, seen: list[tuple[Status, set[str]]]) -> None:
    for status, keys in ((Status.SUCCESS, ends.success), (Status.FAILURE, ends.failure)):
        reached = [written for outcome, written in seen if outcome is status]
        assert keys is not None or not reached, f"{status}, which is called impossible"
        assert keys is None or reached or not seen, f"{status} is called possible, and never seen"
        for written in reached:
            assert keys <= written, f"{keys - written} called written at {status}"


@pytest.mark.parametrize("word", [*COMPOSITES.values(), *ASKING.values()])
def test_a_composite_ends_as_its_definition_says(word):
    policies = [{}] if not word.options else [{}, *({"policy": one} for one in ("all", "any", 2))]
    if word.form is Form.CASES:
        chance = random.Random(0)
        value = {"value": lambda: chance.choice(["a", "b", "c", "d"])}
        policies = [{**value, "cases": ("a", "b", "c")}, {**value, "cases": ("a", "b")}]
    for ways, policy in itertools.product(
        itertools.product(POSSIBLE, repeat=word.most or 3), policies
    ):
        children = [claimed(way, f"c{i}") for i, way in enumerate(ways)]
        ends = word.outcomes(children, policy, frozenset())
        options = policy | word.from_context(ToyContext(clock=HastyClock()))
        seen = observe(lambda made, o=options: word(word.key, made, **o), len(ways), ways)
        judge(ends, seen)


@pytest.mark.parametrize("ways", POSSIBLE)
@pytest.mark.parametrize("word", [*map(MODIFIERS["force"].of, ("success", "failure")), *OTHERS])
def test_a_modifier_ends_as_its_definition_says(word, ways):
    clock = itertools.count()

    def make(children):
        node, *guard = children
        if word.type is None:
            return word(node, guard[0], float)
        return word(node, 3, lambda: float(next(clock)) / 2)

    before = start = frozenset()
    if word.runs_on is not None:
        start = word.runs_on.of(claimed("SF", "c1")(before))
    ends = word.outcomes(claimed(ways, "c0")(start), before)
    judge(ends, observe(make, 1 if word.runs_on is None else 2, (ways, "SF")))
