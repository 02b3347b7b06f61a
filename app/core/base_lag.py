"""How late a base follows its commands: the lag that its measured velocity fits best."""

from __future__ import annotations

from collections import deque

import numpy as np

from config.arrays import Array

_LAGS = np.geomspace(0.01, 1.0, 41)  # that are tried besides what its file says [s]
_FAR_OFF = 2.0  # ratio of two lags from which they differ
_BETTER = 0.25  # share of the squared errors that is left with a lag that is believed
_SURE = 0.05  # squared errors by which it is better at least [m²/s², rad²/s²]


class BaseLag:
    """Follows the commands of a run with many first-order lags at once.

    The model runs up to the stamps of the readings, so that their age counts for nothing; noise of
    the readings makes no lag longer or shorter.
    """

    def __init__(self, told: float) -> None:
        self._told = told  # time constant in the robot's file [s]
        self._lags = np.array([told, *_LAGS])
        self._twists = np.zeros((len(self._lags), 3))
        self._errors = np.zeros(len(self._lags))  # squared, of all readings
        self._sent: deque[tuple[float, Array]] = deque([(-np.inf, np.zeros(3))])
        self._stamp: float | None = None  # up to which the model has run [s]

    def note(self, stamp: float, measured: Array, now: float, sent: Array) -> None:
        """A reading of the base twist (3,) at a stamp, and the command (3,) sent at `now` [s]."""
        if self._stamp is None:
            self._stamp = stamp
        elif stamp > self._stamp:
            while len(self._sent) > 1 and self._sent[1][0] <= stamp:
                self._run_to(max(self._stamp, self._sent[1][0]))
                self._sent.popleft()
            self._run_to(stamp)
            self._errors += ((measured - self._twists) ** 2).sum(axis=1)
        self._sent.append((now, sent))

    def _run_to(self, stamp: float) -> None:
        assert self._stamp is not None
        share = 1.0 - np.exp((self._stamp - stamp) / self._lags)
        self._twists += share[:, None] * (self._sent[0][1] - self._twists)
        self._stamp = stamp

    @property
    def told(self) -> str:
        """That its file is far off, for people; else empty."""
        best = int(self._errors.argmin())
        lag, error, expected = float(self._lags[best]), self._errors[best], self._errors[0]
        is_far = not 1.0 / _FAR_OFF < lag / self._told < _FAR_OFF
        if not is_far or error > _BETTER * expected or expected - error < _SURE:
            return ""
        return (
            f"the base follows its commands {lag:.2f} s late, and the robot's file says "
            f"{self._told:.2f} s: write `base_lag: {lag:.2f}` there"
        )
