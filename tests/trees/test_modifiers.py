"""Delays, cooldowns, guards, forced outcomes and parallel policies, tick by tick."""

from __future__ import annotations

import pytest
from py_trees.common import Status
from tree_toys import Run

from trees.language import MODIFIERS, failed_node


@pytest.fixture
def run(tmp_path):
    return lambda tree: Run(tmp_path, tree)


def test_delay_waits_in_simulated_time_before_the_node_starts(run):
    tree = run("{name: a, delay_s: 0.03, play: {script: S}}")
    assert tree.ticks(3) == "RRR"
    assert tree.events == []
    assert tree.root.feedback_message == "starts in 0.0 s"
    assert tree.ticks(1) == "S"
    assert tree.events == ["a begins", "a ends S"]


def test_cooldown_refuses_a_start_too_soon_after_the_end(run):
    tree = run("{name: a, cooldown_s: 0.03, play: {script: RSFS}}")
    assert tree.ticks(4) == "RSFF"
    assert tree.begun("a") == 1
    assert tree.ticks(1) == "F"
    assert tree.begun("a") == 2
    assert tree.ticks(3) == "FFS"


def test_cooldown_counts_from_a_halt_too(run):
    tree = run("{name: a, cooldown_s: 1, play: {script: R}}")
    tree.ticks(2)
    tree.root.stop(Status.INVALID)
    assert tree.ticks(1) == "F"
    assert tree.begun("a") == 1


def test_once_runs_to_an_end_a_single_time(run):
    for script, expected in (("RSF", "RSSS"), ("FS", "FFFF")):
        tree = run(f"{{name: a, once: true, play: {{script: {script}}}}}")
        assert tree.ticks(4) == expected
        assert tree.begun("a") == 1
    assert run("{once: false, play: {script: SF}}").ticks(2) == "SF"


def test_once_starts_again_after_a_halt_before_its_end(run):
    tree = run("{name: a, once: true, play: {script: RS}}")
    tree.ticks(1)
    tree.root.stop(Status.INVALID)
    assert tree.ticks(2) == "SS"
    assert tree.begun("a") == 2


def test_outcomes_can_be_forced(run):
    tree = run("{force_success: true, name: a, play: {script: RF}}")
    assert tree.ticks(2) == "RS"
    assert tree.root.feedback_message == "success forced (a: said F)"
    assert run("{force_failure: true, play: {script: RS}}").ticks(2) == "RF"
    assert run("{force_failure: false, play: {script: S}}").ticks(1) == "S"
    assert run("{force_success: true, play: {script: I}}").ticks(1) == "S"


def test_while_runs_its_node_as_long_as_the_condition_holds(run):
    tree = run("{name: work, while: {ask: {answers: SSF}}, play: {script: R}}")
    assert tree.ticks(3) == "RRF"
    assert tree.events == ["work begins", "work ends I"]
    assert tree.root.feedback_message == "ask: said F"


def test_unless_ends_well_as_soon_as_its_condition_holds(run):
    tree = run("{name: work, unless: {ask: {answers: FFS}}, play: {script: R}}")
    assert tree.ticks(3) == "RRS"
    assert tree.events == ["work begins", "work ends I"]
    assert run("{unless: {ask: {answers: F}}, play: {script: RF}}").ticks(2) == "RF"


def test_a_guard_is_outside_of_the_attempts_and_inside_of_a_forced_outcome(run):
    tree = run("{retry: 9, while: {ask: {answers: SF}}, name: a, play: {script: F}}")
    assert tree.ticks(2) == "RF"
    assert tree.begun("a") == 1
    assert run("{force_success: true, while: {ask: {answers: F}}, play: {script: S}}").ticks(1) == (
        "S"
    )


@pytest.mark.parametrize(
    "guard",
    [
        "while: {ask: {answers: SRRS}}",
        "while: {not: {ask: {answers: FRRF}}}",
        "unless: {ask: {answers: FRRF}}",
        "unless: {not: {ask: {answers: SRRS}}}",
        "while: {all_of: [{ask: {answers: SRRS}}, {ask: {answers: S}}]}",
        "unless: {any_of: [{ask: {answers: F}}, {ask: {answers: FRRF}}]}",
    ],
)
def test_a_guarded_node_waits_where_it_is_while_the_answer_is_not_known(run, guard):
    tree = run(f"{{name: work, {guard}, play: {{script: RRS}}}}")
    assert tree.ticks(5) == "RRRRS"  # two of these ticks are not its own
    assert tree.events == ["work begins", "work ends S"]


UNKNOWN = "{name: q, ask: {answers: R}}"


@pytest.mark.parametrize(
    "tree",
    [
        f"{{while: {UNKNOWN}, play: {{script: S}}}}",
        f"{{unless: {UNKNOWN}, play: {{script: S}}}}",
        f"{{while: {{not: {UNKNOWN}}}, play: {{script: S}}}}",
        f"{{unless: {{not: {UNKNOWN}}}, play: {{script: S}}}}",
        f"{{while: {{all_of: [{UNKNOWN}, {{ask: {{answers: S}}}}]}}, play: {{script: S}}}}",
        f"{{unless: {{any_of: [{{ask: {{answers: F}}}}, {UNKNOWN}]}}, play: {{script: S}}}}",
        f"reactive_fallback: [{UNKNOWN}, play: {{script: S}}]",
        f"sequence: [{UNKNOWN}, play: {{script: S}}]",
        f"parallel: [{UNKNOWN}, {UNKNOWN}]",
        "{invert: true, name: q, ask: {answers: R}}",
        f"{{invert: true, sequence: [{UNKNOWN}]}}",
        f"{{invert: true, fallback: [{UNKNOWN}]}}",
        UNKNOWN,
        f"not: {UNKNOWN}",
        f"any_of: [{UNKNOWN}, {{ask: {{answers: F}}}}]",
    ],
)
def test_what_stays_not_known_fails_whoever_asks_and_nothing_below_it_runs(run, tree):
    tree = run(tree)
    assert tree.ticks(100) == 100 * "R"
    assert tree.ticks(1) == "F"
    assert tree.events == []
    assert failed_node(tree.root).name == "q"


@pytest.mark.parametrize(
    ("asked", "answer"),
    [
        ("all_of: [{ask: {answers: R}}, {ask: {answers: F}}]", "F"),
        ("any_of: [{ask: {answers: R}}, {ask: {answers: S}}]", "S"),
        ("all_of: [{ask: {answers: R}}, {ask: {answers: S}}]", "R"),
        ("not: {any_of: [{ask: {answers: F}}, {ask: {answers: R}}]}", "R"),
        ("wait_until: {ask: {answers: R}}", "R"),
    ],
)
def test_conditions_are_joined_as_kleene_says(run, asked, answer):
    assert run(asked).ticks(1) == answer


def test_who_waits_until_something_is_known_waits_on_and_until_works_meanwhile(run):
    assert run(f"wait_until: {UNKNOWN}").ticks(250) == 250 * "R"
    tree = run(f"until: [{UNKNOWN}, {{name: look, play: {{script: S}}}}]")
    assert tree.ticks(250) == 250 * "R"
    assert tree.begun("look") == 2


@pytest.mark.parametrize(
    "modifier",
    [
        "timeout_s: 9",
        "delay_s: 0.01",
        "invert: true",
        "retry: 9",
        "repeat: 9",
        "once: true",
        "cooldown_s: 9",
        "unless: {ask: {answers: F}}",
        "while: {ask: {answers: S}}",
        "force_success: true",
        "force_failure: true",
    ],
)
def test_every_modifier_passes_exceptions_and_halts_its_node_once(run, modifier):
    tree = run(f"{{name: a, {modifier}, play: {{script: RX}}}}")
    tree.ticks(2 if "delay" in modifier else 1)
    with pytest.raises(RuntimeError, match=r"^a broke$"):
        tree.ticks(1)
    tree.root.stop(Status.INVALID)
    tree.root.stop(Status.INVALID)
    assert tree.events == ["a begins", "a ends I"]


def test_all_modifiers_together_wrap_in_the_order_of_their_table(run):
    tree = run("""
force_failure: false
force_success: true
while: {ask: {answers: S}}
unless: {ask: {answers: F}}
cooldown_s: 1
once: true
repeat: 1
retry: 1
invert: true
delay_s: 1
timeout_s: 1
play: {script: S}
""")
    node, keys = tree.root, []
    while node.children:
        keys.append(node.key)
        node = node.children[-1]
    words = [key.removesuffix("_s") for key in MODIFIERS if key != "force_failure"]
    assert keys[::-1] == words


PARALLEL = {
    ("all", "S,RS"): "RS",
    ("all", "R,RF"): "RF",
    ("any", "F,RF"): "RF",
    ("any", "I,RS"): "RS",
    ("2", "F,RS,RRS"): "RRS",
    ("2", "F,RF,R"): "RF",
}


@pytest.mark.parametrize(("case", "expected"), PARALLEL.items(), ids=map(str, PARALLEL))
def test_parallel_ends_as_soon_as_its_policy_is_decided(run, case, expected):
    policy, scripts = case
    children = ", ".join(f"play: {{script: {script}}}" for script in scripts.split(","))
    tree = run(f"parallel: {{policy: {policy}, children: [{children}]}}")
    assert tree.ticks(len(expected)) == expected
    assert not any(child.status is Status.RUNNING for child in tree.root.children)


def test_parallel_halts_those_that_are_not_needed_any_more(run):
    tree = run("""
parallel:
  policy: any
  children: [{name: a, play: {script: R}}, {name: b, play: {script: FS}}, play: {script: RS}]
""")
    assert tree.ticks(2) == "RS"
    assert tree.begun("b") == 1
    assert "a ends I" in tree.events
    assert tree.root.feedback_message == "play: said S"


@pytest.mark.parametrize(
    ("tree", "expected"),
    [
        ("fallback: [play: {script: I}, play: {script: S}]", "S"),
        ("{retry: 2, play: {script: I}}", "RF"),
        ("{invert: true, play: {script: I}}", "S"),
        ("reactive_sequence: [play: {script: I}]", "F"),
        ("reactive_fallback: [play: {script: I}, play: {script: RS}]", "RS"),
        ("forever: {play: {script: IS}}", "RS"),
        ("until: [play: {script: I}, play: {script: I}]", "F"),
        ("{delay_s: 0.01, play: {script: I}}", "RF"),
        ("{repeat: 2, play: {script: SI}}", "RF"),
        ("{once: true, play: {script: IS}}", "FF"),
        ("{while: {ask: {answers: S}}, play: {script: I}}", "F"),
        ("{unless: {ask: {answers: F}}, play: {script: I}}", "F"),
    ],
)
def test_a_child_that_comes_back_invalid_has_failed_everywhere(run, tree, expected):
    assert run(tree).ticks(len(expected)) == expected
