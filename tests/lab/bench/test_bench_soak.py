"""The soak carries objects, injects faults, and accounts for both."""

import pytest
from bench_call import report

from hw import INJECTABLE
from lab.bench.soak import LONGEST_S


def test_the_faults_of_the_soak_can_be_injected():
    assert set(LONGEST_S) <= set(INJECTABLE)


@pytest.mark.slow
def test_a_soak_accounts_for_every_object_and_fault(tmp_path):
    kept = report(tmp_path, "soak", "--hours", "0.05", "--seed", 3)
    soak = kept["soak"]
    assert soak["hours"] == pytest.approx(0.05, abs=1e-3)
    assert soak["carried"] >= 2
    assert sum(soak["faults"].values()) == 3
    assert soak["unaccounted"] == 0
    assert not any(soak["violations"].values())
    assert "not accounted for" in kept["stdout"]
