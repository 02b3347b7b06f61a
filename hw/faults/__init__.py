"""Fault injection: tests how a task copes with faults of the robot and its world.

`FaultInjection` is a robot that has the faults named in `INJECTABLE`.
"""

from hw.faults.effects import Injectable, InjectionError
from hw.faults.injection import INJECTABLE, FaultInjection, injectable
