"""Result of a calibration: the transform, its quality, and its file."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pinocchio import SE3

from config import UserError, counted
from lab.calibration.fit import Spread


class CalibrationError(UserError):
    """There is no result, or none that is good enough."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """A result beyond one of these is refused."""

    residual: float  # in the unit of the residual
    uncertainty: Spread
    check: Spread


@dataclass(frozen=True, kw_only=True, eq=False)
class Calibration:
    """A transform and its quality."""

    key: str  # key of the transform in the robot file
    what: str  # the transform in words
    transform: SE3
    views: int
    held_out: int  # number of views left out of the first fit
    residual: float  # root mean square over all views
    unit: str  # of the residual
    uncertainty: Spread  # standard error of the transform
    check: Spread  # worst held-out view, by the fit without them
    from_nominal: Spread  # distance from the robot file
    limits: Limits
    hint: str  # probable causes of a poor result

    def shortcomings(self) -> list[str]:
        """Why it is not good enough; empty if it is."""
        limits = self.limits
        rows = (
            ("the residual", self.residual, limits.residual, self.unit),
            ("the uncertainty", self.uncertainty.mm, limits.uncertainty.mm, "mm"),
            ("the uncertainty", self.uncertainty.deg, limits.uncertainty.deg, "deg"),
            ("a held-out view is off by", self.check.mm, limits.check.mm, "mm"),
            ("a held-out view is off by", self.check.deg, limits.check.deg, "deg"),
        )
        return [
            f"{name} {value:.2f} {unit} (allowed: {limit:g})"
            for name, value, limit, unit in rows
            if not value <= limit  # NaN is no good either
        ]

    def require_good(self) -> None:
        """Refuse a poor result. Raises CalibrationError: it is poor."""
        if poor := self.shortcomings():
            raise CalibrationError(f"refused: {', '.join(poor)}; {self.hint}")

    def lines(self) -> list[str]:
        """For people."""
        x, y, z = 1e3 * self.transform.translation
        moved = self.from_nominal
        return [
            f"{self.what}: {x:.2f}, {y:.2f}, {z:.2f} mm; "
            f"{moved.mm:.2f} mm and {moved.deg:.3f} deg from the robot file",
            f"{counted(self.views, 'view')}, residual {self.residual:.3f} {self.unit} rms, "
            f"uncertainty {self.uncertainty.mm:.2f} mm and {self.uncertainty.deg:.3f} deg",
            f"{counted(self.held_out, 'held-out view')}, the worst off by "
            f"{self.check.mm:.2f} mm and {self.check.deg:.3f} deg",
        ]

    def yaml(self, command: str) -> str:
        """The file: the transform as the robot file takes it, and its quality."""
        rows = [", ".join(f"{value:.9f}" for value in row) for row in self.transform.rotation]
        xyz = ", ".join(f"{value:.6f}" for value in self.transform.translation)
        sure, check = self.uncertainty, self.check
        return "\n".join(
            (
                f"# {self.what}, by `{command}`.",
                f"{self.key}:",
                f"  xyz: [{xyz}]",
                "  rotation:",
                *(f"    - [{row}]" for row in rows),
                "quality:",
                f"  views: {self.views}",
                f"  residual: {self.residual:.4f}  # {self.unit}, rms",
                f"  uncertainty: {{mm: {sure.mm:.3f}, deg: {sure.deg:.4f}}}",
                f"  held_out: {{views: {self.held_out}, mm: {check.mm:.3f}, deg: {check.deg:.4f}}}",
                "",
            )
        )

    def write(self, path: Path, command: str) -> None:
        """Write the file. Raises CalibrationError: it cannot be written."""
        try:
            path.write_text(self.yaml(command), encoding="utf-8")
        except OSError as error:
            raise CalibrationError(f"{path}: {error.strerror}") from error


def require_views(found: int, asked: int, fewest: int) -> None:
    """Refuse too few views. Raises CalibrationError: there are too few."""
    if found < fewest:
        raise CalibrationError(
            f"refused: the board was found in {found} of {asked} images, {fewest} are needed; look "
            "at the light, at what hides the board, and whether the projector is off"
        )


def worst(spreads: list[Spread]) -> Spread:
    """The largest of each."""
    return Spread(
        float(np.max([one.mm for one in spreads])), float(np.max([one.deg for one in spreads]))
    )
