"""The words of the language: tables of composites and modifiers, and the other keys."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from py_trees.behaviour import Behaviour

from trees.words import composites, data_nodes, modifiers
from trees.words.branch import Branch, Now
from trees.words.value_types import ValueType
from trees.words.words import (
    CompositeWord,
    Counterpart,
    Form,
    InOrder,
    ModifierWord,
    Need,
    Option,
    Outcome,
    Source,
    each,
    one_of,
    opposite,
    side_by_side,
    until_first_succeeds,
    until_success,
)

CHILDREN = "children"
"""The key of the children where a composite has options."""

NAME = "name"
"""The key that names a node."""

SUBTREE = "subtree"
"""The key of a node that stands for the tree of another file."""

_ALL, _ANY = InOrder(Outcome.SUCCESS), InOrder(Outcome.FAILURE)
_POLICY = Option(
    type=ValueType(types=(int,), choices=("all", "any"), least=1),
    default="all",
    description="How many children have to succeed; it fails when this number is out of reach.",
)

COMPOSITES: Mapping[str, CompositeWord] = {
    word.node.key: word
    for word in (
        CompositeWord(
            node=composites.Sequence,
            symbol="→",
            outcomes=_ALL,
            counterpart=Counterpart("Sequence"),
        ),
        CompositeWord(
            node=composites.Fallback,
            symbol="?",
            outcomes=_ANY,
            counterpart=Counterpart("Fallback"),
        ),
        CompositeWord(
            node=composites.ReactiveSequence,
            symbol="⇉",
            outcomes=_ALL,
            is_reactive=True,
            counterpart=Counterpart("ReactiveSequence"),
        ),
        CompositeWord(
            node=composites.ReactiveFallback,
            symbol="⁇",
            outcomes=_ANY,
            is_reactive=True,
            counterpart=Counterpart("ReactiveFallback"),
        ),
        CompositeWord(
            node=composites.Parallel,
            symbol="‖",
            at_once=True,
            outcomes=side_by_side,
            options={"policy": _POLICY},
            counterpart=Counterpart("Parallel"),
        ),
        CompositeWord(
            node=composites.Forever,
            symbol="∞",
            outcomes=until_success,
            takes_time=True,
            needs=Need.FAILURE,
            children="one node",
            most=1,
            counterpart=Counterpart("RetryUntilSuccessful", fixed=(("num_attempts", "-1"),)),
        ),
        CompositeWord(
            node=composites.Until,
            symbol="↻",
            outcomes=until_first_succeeds,
            takes_time=True,
            children="a question, then the work to do",
            least=2,
            counterpart=None,
        ),
        CompositeWord(
            node=composites.AllOf,
            symbol="∧",
            asks=True,
            outcomes=_ALL,
            children="one or more conditions",
            counterpart=Counterpart("ReactiveSequence"),
        ),
        CompositeWord(
            node=composites.AnyOf,
            symbol="∨",
            asks=True,
            outcomes=_ANY,
            children="one or more conditions",
            counterpart=Counterpart("ReactiveFallback"),
        ),
        CompositeWord(
            node=composites.Not,
            symbol="¬",
            asks=True,
            outcomes=opposite,
            children="one condition",
            most=1,
            counterpart=Counterpart("Inverter"),
        ),
        CompositeWord(
            node=composites.ResumingSequence,
            symbol="⇥",
            outcomes=_ALL,
            counterpart=Counterpart("SequenceWithMemory"),
        ),
        CompositeWord(
            node=data_nodes.ForEach,
            symbol="∀",
            form=Form.EACH,
            outcomes=each,
            children="an `item`, values `in`, and what to `do`",
            counterpart=Counterpart("Sequence"),
        ),
        CompositeWord(
            node=data_nodes.Switch,
            symbol="⎇",
            form=Form.CASES,
            outcomes=one_of,
            children="a `value`, `cases`, and perhaps `else`",
            counterpart=None,
        ),
    )
}

_SECONDS = ValueType(types=(float,), above=0.0, most=604_800.0)
_COUNT = ValueType(types=(int,), least=1, most=100_000)
_FLAG = ValueType(types=(bool,))


def _flag(make: Callable[[Behaviour], Branch]) -> Callable[[Behaviour, bool, Now], Behaviour]:
    """A modifier that is switched on or off."""
    return lambda node, wanted, now: make(node) if wanted else node


MODIFIERS: Mapping[str, ModifierWord] = {
    "timeout_s": ModifierWord(
        node=modifiers.Timeout,
        wrap=modifiers.Timeout,
        type=_SECONDS,
        fails=(Source.FAILURE, Source.EARLY),
        needs=Need.TIME,
        counterpart=Counterpart("Timeout", port="msec", scale=1000),
    ),
    "delay_s": ModifierWord(
        node=modifiers.Delay,
        wrap=modifiers.Delay,
        type=_SECONDS,
        takes_time=True,
        counterpart=Counterpart("Delay", port="delay_msec", scale=1000),
    ),
    "invert": ModifierWord(
        node=modifiers.Invert,
        wrap=_flag(modifiers.Invert),
        type=_FLAG,
        succeeds=(Source.FAILURE,),
        fails=(Source.SUCCESS,),
        counterpart=Counterpart("Inverter"),
    ),
    "retry": ModifierWord(
        node=modifiers.Retry,
        wrap=modifiers.Retry,
        type=_COUNT,
        takes_time=True,
        needs=Need.FAILURE,
        counterpart=Counterpart("RetryUntilSuccessful", port="num_attempts"),
    ),
    "repeat": ModifierWord(
        node=modifiers.Repeat,
        wrap=lambda node, rounds, now: modifiers.Repeat(node, rounds),
        type=_COUNT,
        takes_time=True,
        counterpart=Counterpart("Repeat", port="num_cycles"),
    ),
    "once": ModifierWord(
        node=modifiers.Once,
        wrap=_flag(modifiers.Once),
        type=_FLAG,
        counterpart=Counterpart("RunOnce", fixed=(("then_skip", "false"),)),
    ),
    "cooldown_s": ModifierWord(
        node=modifiers.Cooldown,
        wrap=modifiers.Cooldown,
        type=_SECONDS,
        fails=(Source.FAILURE, Source.EARLY),
        counterpart=None,
    ),
    "unless": ModifierWord(
        node=modifiers.Unless,
        wrap=lambda node, condition, now: modifiers.Unless(condition, node),
        succeeds=(Source.SUCCESS, Source.EARLY),
        runs_on=Outcome.FAILURE,
        counterpart=Counterpart("ReactiveFallback"),
    ),
    "while": ModifierWord(
        node=modifiers.While,
        wrap=lambda node, condition, now: modifiers.While(condition, node),
        fails=(Source.FAILURE, Source.EARLY),
        runs_on=Outcome.SUCCESS,
        counterpart=Counterpart("ReactiveSequence"),
    ),
    "force_success": ModifierWord(
        node=modifiers.ForceSuccess,
        wrap=_flag(modifiers.ForceSuccess),
        type=_FLAG,
        succeeds=(Source.SUCCESS, Source.FAILURE),
        fails=(),
        needs=Need.FAILURE,
        counterpart=Counterpart("ForceSuccess"),
    ),
    "force_failure": ModifierWord(
        node=modifiers.ForceFailure,
        wrap=_flag(modifiers.ForceFailure),
        type=_FLAG,
        succeeds=(),
        fails=(Source.SUCCESS, Source.FAILURE),
        needs=Need.SUCCESS,
        counterpart=Counterpart("ForceFailure"),
    ),
}
"""Innermost first: this order holds whatever the order in the file."""

RESERVED = frozenset({NAME, SUBTREE, *COMPOSITES, *MODIFIERS})
"""Words that no leaf may take as its key."""
