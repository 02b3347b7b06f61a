"""Staged disturbances: what the robot says is true, and the judge notices if not."""

import pytest
from bench_call import refused, report

from app.core import End
from lab.bench.untruth import Case, _verdict
from lab.bench.untruth_cases import CASES


@pytest.mark.slow
def test_what_nobody_noticed_before_is_noticed(tmp_path):
    """A base that is held back, a picture that hangs, and a laser that does."""
    names = ("held back on the way", "follows a frozen picture", "scan frozen")
    only = [word for name in names for word in ("--only", name)]
    kept = report(tmp_path, "untruth", *only, "--workers", 1)
    assert {one["case"]: one["verdict"] for one in kept["results"]} == dict.fromkeys(names, "right")


class Run:
    hang = False

    def __init__(self, true: bool, number: int = 2) -> None:
        self.case = Case(
            name="it", task="", scene={}, true=lambda run: true, count=lambda run: number
        )


@pytest.mark.parametrize(
    ("true", "end", "said", "verdict"),
    [
        (True, End.SUCCESS, [], "right"),
        (False, End.SUCCESS, [], "wrong success"),
        (False, End.FAILURE, [], "right"),
        (True, End.FAILURE, [], "wrong failure"),
        (True, End.SUCCESS, ["counted 2", "counted at least 1"], "right"),
        (True, End.SUCCESS, ["counted 1"], "wrong count"),
        (True, End.SUCCESS, ["counted at least 3"], "wrong count"),
        (True, End.CRASH, [], "crash"),
    ],
)
def test_the_judge(true, end, said, verdict):
    assert _verdict(Run(true), end, said) == verdict


def test_every_case_has_a_name_of_its_own():
    assert len({case.name for case in CASES}) == len(CASES) >= 60
    refused("did you mean `nobody near`?", "untruth", "--only", "nobody nera")
