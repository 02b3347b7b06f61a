"""The modifiers, each with all that is known about it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from py_trees.behaviour import Behaviour

from trees.language import modifiers
from trees.language.branch import Branch, Now
from trees.language.ends import Need, Outcome, Source
from trees.language.least_times import longer, nothing, times, unchanged
from trees.language.value_types import ValueType
from trees.language.word_types import Counterpart, ModifierWord

_SECONDS = ValueType(types=(float,), above=0.0, most=604_800.0)
_COUNT = ValueType(types=(int,), least=1, most=100_000)
_FLAG = ValueType(types=(bool,))


def _flag(make: Callable[[Behaviour], Branch]) -> Callable[[Behaviour, bool, Now], Behaviour]:
    """A modifier that is there or not."""
    return lambda node, wanted, now: make(node) if wanted else node


MODIFIERS: Mapping[str, ModifierWord] = {
    "timeout_s": ModifierWord(
        node=modifiers.Timeout,
        wrap=lambda node, seconds, now: modifiers.Timeout(node, seconds, now),
        type=_SECONDS,
        lasts=unchanged,
        succeeds=(Source.SUCCESS,),
        fails=(Source.FAILURE, Source.EARLY),
        runs_on=None,
        takes_time=False,
        needs=Need.TIME,
        counterpart=Counterpart("Timeout", port="msec", scale=1000),
    ),
    "delay_s": ModifierWord(
        node=modifiers.Delay,
        wrap=lambda node, seconds, now: modifiers.Delay(node, seconds, now),
        type=_SECONDS,
        lasts=longer,
        succeeds=(Source.SUCCESS,),
        fails=(Source.FAILURE,),
        runs_on=None,
        takes_time=True,
        needs=Need.NOTHING,
        counterpart=Counterpart("Delay", port="delay_msec", scale=1000),
    ),
    "invert": ModifierWord(
        node=modifiers.Invert,
        wrap=_flag(modifiers.Invert),
        type=_FLAG,
        lasts=nothing,
        succeeds=(Source.FAILURE,),
        fails=(Source.SUCCESS,),
        runs_on=None,
        takes_time=False,
        needs=Need.NOTHING,
        counterpart=Counterpart("Inverter"),
    ),
    "retry": ModifierWord(
        node=modifiers.Retry,
        wrap=lambda node, attempts, now: modifiers.Retry(node, attempts, now),
        type=_COUNT,
        lasts=unchanged,
        succeeds=(Source.SUCCESS,),
        fails=(Source.FAILURE,),
        runs_on=None,
        takes_time=True,
        needs=Need.FAILURE,
        counterpart=Counterpart("RetryUntilSuccessful", port="num_attempts"),
    ),
    "repeat": ModifierWord(
        node=modifiers.Repeat,
        wrap=lambda node, rounds, now: modifiers.Repeat(node, rounds),
        type=_COUNT,
        lasts=times,
        succeeds=(Source.SUCCESS,),
        fails=(Source.FAILURE,),
        runs_on=None,
        takes_time=True,
        needs=Need.NOTHING,
        counterpart=Counterpart("Repeat", port="num_cycles"),
    ),
    "once": ModifierWord(
        node=modifiers.Once,
        wrap=_flag(modifiers.Once),
        type=_FLAG,
        lasts=nothing,
        succeeds=(Source.SUCCESS,),
        fails=(Source.FAILURE,),
        runs_on=None,
        takes_time=False,
        needs=Need.NOTHING,
        counterpart=Counterpart("RunOnce", fixed=(("then_skip", "false"),)),
    ),
    "cooldown_s": ModifierWord(
        node=modifiers.Cooldown,
        wrap=lambda node, seconds, now: modifiers.Cooldown(node, seconds, now),
        type=_SECONDS,
        lasts=unchanged,
        succeeds=(Source.SUCCESS,),
        fails=(Source.FAILURE, Source.EARLY),
        runs_on=None,
        takes_time=False,
        needs=Need.NOTHING,
        counterpart=None,
    ),
    "unless": ModifierWord(
        node=modifiers.Unless,
        wrap=lambda node, condition, now: modifiers.Unless(condition, node),
        type=None,
        lasts=nothing,
        succeeds=(Source.SUCCESS, Source.EARLY),
        fails=(Source.FAILURE,),
        runs_on=Outcome.FAILURE,
        takes_time=False,
        needs=Need.NOTHING,
        counterpart=Counterpart("ReactiveFallback"),
    ),
    "while": ModifierWord(
        node=modifiers.While,
        wrap=lambda node, condition, now: modifiers.While(condition, node),
        type=None,
        lasts=unchanged,
        succeeds=(Source.SUCCESS,),
        fails=(Source.FAILURE, Source.EARLY),
        runs_on=Outcome.SUCCESS,
        takes_time=False,
        needs=Need.NOTHING,
        counterpart=Counterpart("ReactiveSequence"),
    ),
    "force_success": ModifierWord(
        node=modifiers.ForceSuccess,
        wrap=_flag(modifiers.ForceSuccess),
        type=_FLAG,
        lasts=nothing,
        succeeds=(Source.SUCCESS, Source.FAILURE),
        fails=(),
        runs_on=None,
        takes_time=False,
        needs=Need.FAILURE,
        counterpart=Counterpart("ForceSuccess"),
    ),
    "force_failure": ModifierWord(
        node=modifiers.ForceFailure,
        wrap=_flag(modifiers.ForceFailure),
        type=_FLAG,
        lasts=nothing,
        succeeds=(),
        fails=(Source.SUCCESS, Source.FAILURE),
        runs_on=None,
        takes_time=False,
        needs=Need.SUCCESS,
        counterpart=Counterpart("ForceFailure"),
    ),
}
"""Innermost first: this order holds whatever the order in the file."""
