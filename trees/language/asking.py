"""Conditions made of conditions."""

from __future__ import annotations

from trees.language.branch import OPPOSITE, Branch, Ticking
from trees.language.composites import ReactiveFallback, ReactiveSequence


class AllOf(ReactiveSequence):
    """A condition: succeeds if all the conditions below it do."""

    key = "all_of"
    is_condition = True


class AnyOf(ReactiveFallback):
    """A condition: succeeds if one of the conditions below it does."""

    key = "any_of"
    is_condition = True


class Not(Branch):
    """A condition: succeeds if the condition below it fails."""

    key = "not"
    is_condition = True

    def advance(self) -> Ticking:
        """Ask, and answer the opposite."""
        status = yield from self.run(self.children[0])
        self.feedback_message = f"not ({self.feedback_message})"
        return OPPOSITE.get(status, status)
