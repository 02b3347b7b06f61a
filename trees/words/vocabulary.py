"""The words of the language: tables of composites and modifiers, and the other keys."""

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

CHILDREN = "children"  # the key of the children where a composite has options

NAME = "name"  # the key that names a node

SUBTREE = "subtree"  # the key of a node that stands for the tree of another file

_ALL, _ANY = InOrder(Outcome.SUCCESS), InOrder(Outcome.FAILURE)
_POLICY = Option(
    type=ValueType(types=(int,), choices=("all", "any"), least=1),
    default="all",
    description="How many children have to succeed; it fails when this number is out of reach.",
)

_CONDITIONS = "one or more conditions"
_REACTIVE_SEQUENCE = Counterpart("ReactiveSequence")
_REACTIVE_FALLBACK = Counterpart("ReactiveFallback")
_INVERTER = Counterpart("Inverter")

COMPOSITES: Mapping[str, CompositeWord] = {
    word.node.key: word
    for word in (
        CompositeWord(composites.Sequence, Counterpart("Sequence"), "→", _ALL),
        CompositeWord(composites.Fallback, Counterpart("Fallback"), "?", _ANY),
        CompositeWord(composites.ReactiveSequence, _REACTIVE_SEQUENCE, "⇉", _ALL, is_reactive=True),
        CompositeWord(composites.ReactiveFallback, _REACTIVE_FALLBACK, "⁇", _ANY, is_reactive=True),
        CompositeWord(
            composites.Parallel,
            Counterpart("Parallel"),
            "‖",
            side_by_side,
            at_once=True,
            options={"policy": _POLICY},
        ),
        CompositeWord(
            composites.Forever,
            Counterpart("RetryUntilSuccessful", fixed=(("num_attempts", "-1"),)),
            "∞",
            until_success,
            takes_time=True,
            needs=Need.FAILURE,
            children="one node",
            most=1,
        ),
        CompositeWord(
            composites.Until,
            None,
            "↻",
            until_first_succeeds,
            takes_time=True,
            children="a question, then the work to do",
            least=2,
        ),
        CompositeWord(
            composites.WaitUntil,
            None,
            "⧖",
            until_first_succeeds,
            takes_time=True,
            asks=True,
            children="one condition",
            most=1,
        ),
        CompositeWord(
            composites.AllOf, _REACTIVE_SEQUENCE, "∧", _ALL, asks=True, children=_CONDITIONS
        ),
        CompositeWord(
            composites.AnyOf, _REACTIVE_FALLBACK, "∨", _ANY, asks=True, children=_CONDITIONS
        ),
        CompositeWord(
            composites.Not, _INVERTER, "¬", opposite, asks=True, children="one condition", most=1
        ),
        CompositeWord(composites.ResumingSequence, Counterpart("SequenceWithMemory"), "⇥", _ALL),
        CompositeWord(
            data_nodes.ForEach,
            Counterpart("Sequence"),
            "∀",
            each,
            form=Form.EACH,
            children="an `item`, values or a path `in`, and what to `do`",
        ),
        CompositeWord(
            data_nodes.Switch,
            None,
            "⎇",
            one_of,
            form=Form.CASES,
            children="a `value`, `cases`, and perhaps `else`",
        ),
    )
}

_SECONDS = ValueType(types=(float,), above=0.0, most=604_800.0)
_COUNT = ValueType(types=(int,), least=1, most=100_000)
_FLAG = ValueType(types=(bool,))


def _flag(make: Callable[[Behaviour], Branch]) -> Callable[[Behaviour, bool, Now], Behaviour]:
    """A modifier that is switched on or off."""
    return lambda node, wanted, now: make(node) if wanted else node


_OR_EARLY = (Source.FAILURE, Source.EARLY)
_EITHER = (Source.SUCCESS, Source.FAILURE)

MODIFIERS: Mapping[str, ModifierWord] = {
    "timeout_s": ModifierWord(
        modifiers.Timeout,
        Counterpart("Timeout", port="msec", scale=1000),
        _SECONDS,
        modifiers.Timeout,
        fails=_OR_EARLY,
        needs=Need.TIME,
    ),
    "delay_s": ModifierWord(
        modifiers.Delay,
        Counterpart("Delay", port="delay_msec", scale=1000),
        _SECONDS,
        modifiers.Delay,
        takes_time=True,
    ),
    "invert": ModifierWord(
        modifiers.Invert,
        _INVERTER,
        _FLAG,
        _flag(modifiers.Invert),
        succeeds=(Source.FAILURE,),
        fails=(Source.SUCCESS,),
    ),
    "retry": ModifierWord(
        modifiers.Retry,
        Counterpart("RetryUntilSuccessful", port="num_attempts"),
        _COUNT,
        modifiers.Retry,
        takes_time=True,
        again=Outcome.FAILURE,
        needs=Need.FAILURE,
    ),
    "repeat": ModifierWord(
        modifiers.Repeat,
        Counterpart("Repeat", port="num_cycles"),
        _COUNT,
        lambda node, rounds, now: modifiers.Repeat(node, rounds),
        takes_time=True,
        again=Outcome.SUCCESS,
    ),
    "once": ModifierWord(
        modifiers.Once,
        Counterpart("RunOnce", fixed=(("then_skip", "false"),)),
        _FLAG,
        _flag(modifiers.Once),
    ),
    "cooldown_s": ModifierWord(
        modifiers.Cooldown, None, _SECONDS, modifiers.Cooldown, fails=_OR_EARLY
    ),
    "unless": ModifierWord(
        modifiers.Unless,
        _REACTIVE_FALLBACK,
        None,
        lambda node, condition, now: modifiers.Unless(condition, node),
        succeeds=(Source.SUCCESS, Source.EARLY),
        runs_on=Outcome.FAILURE,
    ),
    "while": ModifierWord(
        modifiers.While,
        _REACTIVE_SEQUENCE,
        None,
        lambda node, condition, now: modifiers.While(condition, node),
        fails=_OR_EARLY,
        runs_on=Outcome.SUCCESS,
    ),
    "force_success": ModifierWord(
        modifiers.ForceSuccess,
        Counterpart("ForceSuccess"),
        _FLAG,
        _flag(modifiers.ForceSuccess),
        succeeds=_EITHER,
        fails=(),
        needs=Need.FAILURE,
    ),
    "force_failure": ModifierWord(
        modifiers.ForceFailure,
        Counterpart("ForceFailure"),
        _FLAG,
        _flag(modifiers.ForceFailure),
        succeeds=(),
        fails=_EITHER,
        needs=Need.SUCCESS,
    ),
}
"""Innermost first: this order holds whatever the order in the file."""

RESERVED = frozenset({NAME, SUBTREE, *COMPOSITES, *MODIFIERS})  # no leaf may have these
