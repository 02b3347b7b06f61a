"""Tasks that fail, each in a way of its own, and what goes wrong first in them."""

from dataclasses import dataclass

from recorded_runs import fault

from app.core import ScheduledFault

HEAD = """\
task: toy
poses:
  near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}
  far: {xyz: [-40.0, 0.0, 0.7], rpy_deg: [180, 0, 0]}
  above: {xyz: [2.935, 0.0, 0.85], rpy_deg: [180, 0, 0]}
  under_table: {base: [0.0, 1.6], heading_deg: 0}
regions:
  floor: {centre: [0.7, 0.0, 0.3], size: [0.4, 0.4, 0.6]}
  container: {centre: [3.0, 0.0, 0.556], size: [0.44, 0.36, 0.20]}
tree:
"""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A run that fails, and what went wrong first in it."""

    tree: str
    node: str
    """End of the path of the node of the cause."""
    reason: str
    """Expression that fits the cause."""
    topic: str = ""
    outcome: str = "failure"
    faults: tuple[ScheduledFault, ...] = ()
    since: tuple[float, float] = (0.0, 60.0)
    """Between which times the cause is [s]."""


PICK = """
name: pick
retry: {attempts}
sequence:
  - recover
  - navigate: {{to: near}}
  - open_gripper
  - grasp: {{within: floor, patience_s: 0.3}}
  - retreat_check
"""
FETCH = """
name: pick
retry: 2
sequence:
  - recover
  - navigate: {to: above}
  - open_gripper
  - grasp: {within: container}
  - retreat_check
"""

CASES = {
    "a place on the floor inside a table": Case(
        tree="navigate: {to: under_table}",
        node="navigate",
        reason="the base would stand in",
        topic="out of reach",
    ),
    "the object is taken from the hand": Case(
        tree="{name: pick, retry: 1, sequence: ["
        "{navigate: {to: above}}, {grasp: {within: container}}, retreat_check]}",
        node="pick/retreat_check",
        reason="fingers",
        topic="held nothing",
        faults=(fault("object taken", phase="close"),),
    ),
    "nothing in the hand to be placed": Case(
        tree="place: {on: floor}",
        node="place",
        reason="^nothing to place",
        topic="held nothing",
    ),
    "an empty battery and a message about it": Case(
        tree="""
sequence:
  - wait: {duration_s: 1.6}
  - fallback:
      - battery_above: {percent: 99.99}
      - force_failure: true
        say: {text: I must charge.}
""",
        node="battery_above",
        reason="^battery at ",
        topic="battery",
    ),
    "a reflex that nothing clears": Case(
        tree="fallback: [{name: job, sequence: [{navigate: {to: far}}]}, {move_arm: {to: ready}}]",
        node="job/navigate",
        reason="reflex of the arm",
        topic="a fault of the robot",
        faults=(fault("reflex", at_s=0.5),),
        since=(0.5, 0.52),
    ),
    "a bumper, while a timeout runs": Case(
        tree="{timeout_s: 3.0, retry: 9, sequence: [{drive: {forward_m: 2}}]}",
        node="drive",
        reason="bumper of the base",
        topic="a fault of the robot",
        faults=(fault("bumper", at_s=0.3),),
        since=(0.3, 0.32),
    ),
    "an emergency stop with nobody there": Case(
        tree="navigate: {to: far}",
        node="navigate",
        reason="emergency stop",
        topic="emergency stop",
        outcome="hardware fault",
        faults=(fault("emergency stop", at_s=0.4),),
        since=(0.4, 0.42),
    ),
    "a base that does not move": Case(
        tree="navigate: {to: above}",
        node="navigate",
        reason="does not do what it is commanded",
        topic="the robot does not obey",
        outcome="hardware fault",
        faults=(fault("base ignores commands", at_s=0.3),),
    ),
    "a time that was over while one leaf waited": Case(
        tree="{timeout_s: 0.5, sequence: [{wait: {duration_s: 9}}]}",
        node="timeout",
        reason=r"^not done within 0\.5 s \(wait",
        topic="out of time",
    ),
    "a time that was over after failed attempts": Case(
        tree="{timeout_s: 1.5, retry: 99, sequence: [{wait: {duration_s: 0.4}}, holding_object]}",
        node="holding_object",
        reason="the fingers",
        since=(0.3, 0.5),
    ),
    "a remedy that failed as well": Case(
        tree="""
fallback:
  - {name: first way, navigate: {to: far, timeout_s: 0.3}}
  - {name: second way, drive: {forward_m: 9, timeout_s: 0.3}}
""",
        node="second way",
        reason="^not (within|at|done)|after 0.3 s",
        since=(0.5, 0.8),
    ),
    "the remedy after a failure that is expected": Case(
        tree="""
fallback:
  - {name: offer, navigate: {to: far, timeout_s: 0.3}}
  - {name: put back, sequence: [{wait: {duration_s: 0.2}}, {place: {on: floor}}]}
""",
        node="put back/place",
        reason="^nothing to place",
        topic="held nothing",
        since=(0.4, 0.7),
    ),
    "a remedy that fails at once, within an attempt that another one answers": Case(
        tree="""
sequence:
  - {force_success: true, navigate: {to: far, timeout_s: 0.3}}
  - fallback:
      - {name: offer, navigate: {to: far, timeout_s: 0.3}}
      - {name: put back, place: {on: floor}}
      - {name: sorry, invert: true, say: {text: Sorry.}}
""",
        node="put back",
        reason="^nothing to place",
        since=(0.5, 0.8),
    ),
    "a question that said no before the work failed": Case(
        tree="fallback: [holding_object, {navigate: {to: far, timeout_s: 0.3}}]",
        node="navigate",
        reason="^not at far",
    ),
    "one of two at the same time": Case(
        tree="parallel: [{wait: {duration_s: 5}}, "
        "{name: late, sequence: [{wait: {duration_s: 0.2}}, holding_object]}]",
        node="late/holding_object",
        reason="fingers",
        since=(0.1, 0.3),
    ),
}
SLOW = (
    "the object is taken from the hand",
    "a base that does not move",
    "a time that was over after failed attempts",
)
"""Long runs; the quick cases have the same kinds of nodes."""
