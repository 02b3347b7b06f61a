"""Fit the network that tells how likely a grasp holds, and write its weights."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

from lab.grasps.outcomes import read_outcomes
from lab.grasps.scenes import ROBOT

if TYPE_CHECKING:
    from perception.networks import FitReport

LEARNT = ("trained", "bodies", "light")
"""The sets of outcomes that are learnt from."""


def fit_outcomes(folder: Path, out: Path, *, rounds: int, say: Callable[[str], None]) -> None:
    """Fit to all outcomes of `LEARNT` in a folder.

    Args:
        folder: of the outcomes.
        out: the weights file to write.
        rounds: times that every grasp is seen.
        say: told what is done.

    Raises:
        ConfigError: there are no outcomes, or a file cannot be read.
    """
    # Not at the top: torch takes a second to import.
    import torch

    from perception import hand_sizes
    from perception.networks import FitSettings, fit_hold, save_network

    learnt = read_outcomes(folder, *LEARNT)
    settings = FitSettings(rounds=rounds)
    torch.set_num_threads(1)  # the order of sums is then always the same

    def report(done: FitReport) -> None:
        say(f"round {done.round} of {settings.rounds}: loss {done.loss:.4f}")

    say(f"{len(learnt.good)} grasps, {100 * learnt.good.mean():.1f} % of them good")
    network = fit_hold(learnt.patches, learnt.good, ROBOT.gripper, settings, report)
    metadata = {
        "settings": asdict(settings),
        "grasps": len(learnt.good),
        "last_scenes": {kinds: _last_scene(folder, kinds) for kinds in LEARNT},
        "hand": hand_sizes(ROBOT.gripper),
        "licence": "Apache-2.0",
    }
    save_network(network, out, metadata)


def _last_scene(folder: Path, kinds: str) -> int | None:
    """The largest seed among the scenes of a set; None if it is not there."""
    if not list(folder.glob(f"{kinds}-*.npz")):
        return None
    return int(read_outcomes(folder, kinds).scene.max())
