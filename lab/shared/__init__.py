"""Shared by the rooms of the laboratory: machine, worker processes, progress, statistics."""

from lab.shared.environment import machine
from lab.shared.progress_bar import progress
from lab.shared.statistics import bootstrap, interval, paired_difference, percent
from lab.shared.tables import fixed, table
from lab.shared.workers import run_all, run_in_order
