"""Ablation: what is changed in a copy, and what counts as worse."""

from itertools import chain
from pathlib import Path

import pytest

from lab.bench.ablation import AS_IS, LONG_TASKS, TRIALS, Mechanism, mechanisms, rows

SOURCE = "_FAR: float = 0.5  # [m]\n_FARTHER = 2 * _FAR\n"


def change(find: str, replace: str) -> Mechanism:
    return Mechanism(name="it", path="it.py", find=find, replace=replace)


def test_a_constant_is_replaced_and_nothing_that_is_called_like_it():
    assert change("_FAR", "0.0").of(SOURCE) == "_FAR: float = 0.0  # [m]\n_FARTHER = 2 * _FAR\n"
    assert change("2 * _FAR", "0").of(SOURCE).endswith("_FARTHER = 0\n")
    for nowhere in ("_NEAR", "3 * _FAR", "_FAR "):
        with pytest.raises(ValueError, match="stands"):
            change(nowhere, "1").of(SOURCE)


def test_every_listed_mechanism_stands_in_the_product():
    for one in mechanisms(Path("lab/bench/mechanisms.yaml")):
        assert one.of(Path(one.path).read_text()) != Path(one.path).read_text()


def test_worse_is_what_is_worse_beyond_chance_on_the_same_seeds():
    done = {}
    for seed in range(8):
        figures = dict.fromkeys(("not placed", "failed", "attempts", "contacts"), 0.0)
        done[AS_IS, "run task", seed] = [figures | {"seconds": 10.0 + seed}]
        more = {"attempts": 1.0 + seed % 2, "seconds": 9.0 + seed + 2 * (seed % 2)}
        done["it", "run task", seed] = [figures | more]
    done[AS_IS, "grasp eval", 0] = [{"not held": 0.0}] * 3
    done["it", "grasp eval", 0] = [{"not held": 0.0}] * 3
    (row,) = rows([change("_FAR", "0")], done)
    assert (row.trials, row.changed, row.verdict) == (11, 8, "worse: attempts")


def test_what_tasks_are_run_is_shipped():
    for words in (*LONG_TASKS, *chain.from_iterable(TRIALS.values())):
        if words.startswith("run "):
            named = Path(words.split()[1])
            assert (Path("trees") / f"{named}.yaml").exists() or named.exists()
