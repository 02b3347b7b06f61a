"""Faults on request: how a task copes with them is seen before the robot has them.

`INJECTABLE` names what can go wrong, `FaultInjection` is a robot that it goes wrong with. What a
fault does is an `Effect`: on readings in `readings`, on frames in `frames`, on commands and fingers
in `motion`, on objects in `objects`.
"""

from hw.faults.effect import Effect, Site
from hw.faults.injection import FaultInjection
from hw.faults.table import INJECTABLE, Injectable, InjectionError, injectable

__all__ = [
    "INJECTABLE",
    "Effect",
    "FaultInjection",
    "Injectable",
    "InjectionError",
    "Site",
    "injectable",
]
