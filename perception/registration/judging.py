"""Which furniture was moved: the stacks in turn, one a registration."""

from collections.abc import Sequence

from perception.registration.matching import MatchSettings
from perception.registration.registering import Trial

_RECENT = 10  # registrations for which a trial counts


class Judge:
    """Finds furniture that was moved from trials of one stack each (`Registration.trial`)."""

    def __init__(self) -> None:
        self._trials: dict[int, tuple[int, Trial]] = {}
        self._count = 0

    @property
    def tried(self) -> Sequence[int]:
        """The stacks that were tried lately, the newest last."""
        return tuple(self._trials)

    def take(self, trial: Trial | None) -> frozenset[str]:
        """Pieces that were moved, or some of them: when a stack must have been, twice in turn.

        All others in sight had their turn meanwhile. Of stacks that contradict each other alike,
        none can be believed.
        """
        self._count += 1
        oldest = self._count - _RECENT
        self._trials = {k: one for k, one in self._trials.items() if one[0] > oldest}
        if trial is None:
            return frozenset()
        _, before = self._trials.pop(trial.stack, (0, None))
        self._trials[trial.stack] = self._count, trial
        if before is None or min(before.gain, trial.gain) <= 0.0:
            return frozenset()
        trials = [one for _, one in self._trials.values()]
        worth = max(0.0, max(one.gain for one in trials) - MatchSettings.price)
        self._trials = {}
        return frozenset().union(*(one.pieces for one in trials if one.gain > worth))
