"""Which words of the language BehaviorTree.CPP has too, and how it writes them.

Every other word is exported under its own key, as a node that a BehaviorTree.CPP program has to
bring along; the XML carries its model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

NONE: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class Standard:
    """A node that comes with BehaviorTree.CPP and does what a word of the language does."""

    tag: str
    port: str = ""
    """The attribute that takes the word's value; empty if it has none."""
    scale: int = 1
    """The attribute is the value times this, a whole number."""
    fixed: Mapping[str, str] = field(default_factory=lambda: NONE)
    """Attributes that always stand there."""


PARALLEL = "Parallel"
"""The one node whose attributes count its children; see `parallel_counts`."""

STANDARD_COMPOSITES: Mapping[str, Standard] = MappingProxyType(
    {
        "sequence": Standard(tag="Sequence"),
        "fallback": Standard(tag="Fallback"),
        "reactive_sequence": Standard(tag="ReactiveSequence"),
        "reactive_fallback": Standard(tag="ReactiveFallback"),
        "parallel": Standard(tag=PARALLEL),
        "forever": Standard(tag="RetryUntilSuccessful", fixed={"num_attempts": "-1"}),
    }
)
STANDARD_MODIFIERS: Mapping[str, Standard] = MappingProxyType(
    {
        "timeout_s": Standard(tag="Timeout", port="msec", scale=1000),
        "delay_s": Standard(tag="Delay", port="delay_msec", scale=1000),
        "invert": Standard(tag="Inverter"),
        "retry": Standard(tag="RetryUntilSuccessful", port="num_attempts"),
        "repeat": Standard(tag="Repeat", port="num_cycles"),
        "once": Standard(tag="RunOnce", fixed={"then_skip": "false"}),
        "force_success": Standard(tag="ForceSuccess"),
        "force_failure": Standard(tag="ForceFailure"),
        "while": Standard(tag="ReactiveSequence"),
        "unless": Standard(tag="ReactiveFallback"),
    }
)
"""A guard is the reactive composite of its condition and its node."""

GUARD = "_guard"
"""Tells the composite of a guard from one that the task itself has."""

STANDARD_TAGS: Mapping[str, str] = MappingProxyType(
    {
        key.removesuffix("_s"): standard.tag
        for table in (STANDARD_COMPOSITES, STANDARD_MODIFIERS)
        for key, standard in table.items()
    }
)
"""Tags by the key of a built node."""

SCRIPT = "Script"
"""Writes keys: the language's `set`."""

SUBTREE = "SubTree"
MAIN = "Main"
"""The tree that runs the exported task with its default parameters."""

VALUE = "value"
"""The port of an exported modifier that BehaviorTree.CPP does not have."""

PORT_TYPES: Mapping[str, str] = MappingProxyType(
    {
        "bool": "bool",
        "int": "int",
        "float": "double",
        "text": "std::string",
        "pose": "Pose",
        "tool_pose": "ToolPose",
        "base_pose": "BasePose",
        "posture": "Posture",
        "region": "Region",
    }
)
"""What a port's type is called, by the type of a parameter in a task file."""

ANY_TYPE = "BT::AnyTypeAllowed"

RESERVED_PORTS = frozenset({"ID", "name"})
"""Attributes that mean something else in BehaviorTree.CPP, besides those that begin with `_`."""


def parallel_counts(policy: object, children: int) -> dict[str, str]:
    """The attributes of a `Parallel` for a policy of `parallel`."""
    if policy == "all":
        return {"success_count": "-1", "failure_count": "1"}
    if policy == "any":
        return {"success_count": "1", "failure_count": "-1"}
    return {"success_count": str(policy), "failure_count": str(children - int(str(policy)) + 1)}


def parallel_policy(success: str, failure: str, children: int) -> str | int | None:
    """The policy of `parallel` that does what the attributes say; None if none does."""
    for policy in ("all", "any"):
        if parallel_counts(policy, children) == {
            "success_count": success,
            "failure_count": failure,
        }:
            return policy
    if not success.isdecimal():
        return None
    counts = parallel_counts(int(success), children)
    return int(success) if counts["failure_count"] == failure else None
