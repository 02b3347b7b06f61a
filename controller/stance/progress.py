"""Progress to a goal: notices a stall, as in a local minimum of the QP."""

from math import inf

from controller.stance.bias import Remaining

CLOSE_DISTANCE = 0.06  # nearer there is no stall, and a detour is over [m]
_PROGRESS = 1e-3  # least progress of end effector, base or arm [m, s and rad]
_PATIENCE = 1.0  # no progress for this long is a stall [s]


class Progress:
    """The least that remained of a motion, and for how long it has not become less."""

    def __init__(self, period: float) -> None:
        self._period = period
        self.restart()

    def restart(self) -> None:
        """Forget the motion."""
        self.was_close = False  # whether the goal was nearly reached
        self._stage = False, False
        self._least = inf, inf, inf
        self._waited = 0

    def has_stalled(self, remaining: Remaining, age: int, *, goal_moves: bool, waits: bool) -> bool:
        """Whether end effector, base and arm have made no progress for a while.

        It was asked last `age` periods ago. On a way among obstacles only progress of the base
        counts, whatever the arm does meanwhile. A robot that is close to its goal, follows
        one that moves or `waits` for a moving obstacle never stalls.
        """
        lead = remaining.lead
        is_close = remaining.distance < CLOSE_DISTANCE
        if is_close or goal_moves:
            self.restart()
            self.was_close = is_close
            return False
        stage = remaining.in_transport, remaining.docks
        if stage != self._stage:
            self._stage, self._least = stage, (inf, inf, inf)
        left = remaining.distance, lead.time_left, remaining.max_joint_error
        if not lead.final and not remaining.in_transport:
            left = inf, lead.time_left, inf
        (a, b, c), (x, y, z) = self._least, left
        if x < a - _PROGRESS or y < b - _PROGRESS or z < c - _PROGRESS:
            self._least, self._waited = (min(a, x), min(b, y), min(c, z)), 0
        elif not waits:
            self._waited += age
        return self._waited * self._period >= _PATIENCE
