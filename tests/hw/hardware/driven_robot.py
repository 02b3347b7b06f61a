"""A loop that drives the emulated Frankie through the gate, as a session does."""

from __future__ import annotations

import time

import numpy as np

from controller import Command
from hw import Refusal
from hw.clock import stopwatch

GO = Command(base_twist=np.array([0.15, 0.0, 0.0]), qd=0.2 * np.eye(7)[5])


def tick(robot, gate, command=None):
    """One turn of a loop; the reading, and why it allows no motion."""
    state, now = robot.read(), robot.clock.now()
    refusal = gate.judge(state, now)
    if refusal is Refusal.READING:
        gate.send(gate.applied, state, now)
    elif command is None or refusal is not None:
        gate.brake(state, now)
    else:
        last = gate.continue_from(state, now)
        gate.send(_towards(last, command, robot.description.limits), state, robot.clock.now())
    time.sleep(0.01)
    return state, refusal


def _towards(last, command, limits):
    step, steps = limits.base_acceleration * 0.01, limits.qdd * 0.01
    return Command(
        base_twist=last.base_twist + np.clip(command.base_twist - last.base_twist, -step, step),
        qd=last.qd + np.clip(command.qd - last.qd, -steps, steps),
    )


def until(robot, gate, done, command=None, patience=60.0):
    """The first reading of which something is true."""
    end = robot.clock.now() + patience
    while robot.clock.now() < end:
        state, refusal = tick(robot, gate, command)
        if done(state):
            return state
    raise AssertionError(f"not within {patience:g} s: {state.faults}, {refusal}")


def has(kind):
    return lambda state: any(fault.kind is kind for fault in state.faults)


def healthy(state) -> bool:
    return not (state.faults or state.recovering)


def go_on(robot, gate, seconds, command) -> float:
    """Want a motion for a while; when the last command was given that moves [s]."""
    given, end = 0.0, stopwatch() + seconds
    while stopwatch() < end:
        now = stopwatch()
        if tick(robot, gate, command)[1] is None:
            given = now
    return given
