"""Fault injection: tests how a task copes with faults of the robot and its world."""

from hw.faults.effects import Injectable, InjectionError
from hw.faults.injection import INJECTABLE, FaultInjection, injectable
