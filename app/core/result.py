"""What a run leaves."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from app.core.folder import RECORDING
from app.core.outcome import Outcome
from app.core.summary import Summary
from app.live import Ending


class Result(NamedTuple):
    """What a run leaves."""

    outcome: Outcome
    summary: Summary
    folder: Path

    def ending(self, explanation: str) -> Ending:
        """What the control page shows in the end."""
        recording = self.folder / RECORDING
        return Ending(
            outcome=self.summary.achieved,
            explanation=explanation,
            recording=recording if recording.is_file() else None,
        )
