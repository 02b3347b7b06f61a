"""What the rooms of the laboratory share: machine, worker processes, progress, statistics."""

from lab.shared.environment import machine
from lab.shared.parts import Functions, PartTimer
from lab.shared.progress_bar import progress
from lab.shared.statistics import interval, paired_difference, percent, share
from lab.shared.workers import ClusterError, run_all

__all__ = [
    "ClusterError",
    "Functions",
    "PartTimer",
    "interval",
    "machine",
    "paired_difference",
    "percent",
    "progress",
    "run_all",
    "share",
]
