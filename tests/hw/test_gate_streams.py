"""Random commands at random times on random readings keep every limit behind the gate.

The judge integrates the robot by itself and shares no code with the gate.
"""

from math import exp

import numpy as np
from pinocchio import SE3

from controller import Command
from hw import Gate, RobotState, UntrustedRobotError
from robots import load_robot

FRANKIE = load_robot("frankie")
LIMITS, LAG = FRANKIE.limits, FRANKIE.arm.lag
DT = 0.01
NAN = float("nan")


class Plant:
    """Joints and base that follow with their lags; without a command for a period they stop."""

    def __init__(self, rng: np.random.Generator) -> None:
        span = LIMITS.q_max - LIMITS.q_min
        near = LIMITS.q_min + 0.02 + (span - 0.04) * np.round(rng.random(7))
        anywhere = LIMITS.q_min + 0.02 + (span - 0.04) * rng.random(7)
        self.q = np.where(rng.random(7) < 0.4, near, anywhere)
        self.qd = np.zeros(7)
        self.base = np.zeros(3)
        self.time = 0.0
        self.overshoot = 0.0
        self.command = Command.stop(7)
        self.valid_until = 0.0
        self.sent: list[tuple[float, np.ndarray]] = []

    def send(self, command: Command) -> Command:
        self.command, self.valid_until = command, self.time + DT
        return command

    def advance(self, seconds: float) -> None:
        end = self.time + seconds
        while self.time < end - 1e-12:
            live = self.time < self.valid_until - 1e-12
            dt = (min(end, self.valid_until) if live else end) - self.time  # exact at any length
            command = self.command if live else Command.stop(7)
            self.q = self.q + LAG * self.qd * (1 - exp(-dt / LAG))
            self.q = self.q + command.qd * (dt - LAG * (1 - exp(-dt / LAG)))
            self.qd = command.qd + (self.qd - command.qd) * exp(-dt / LAG)
            self.base = command.base_twist + (self.base - command.base_twist) * exp(
                -dt / FRANKIE.base.lag
            )
            self.time += dt
            out = max((self.q - LIMITS.q_max).max(), (LIMITS.q_min - self.q).max())
            self.overshoot = max(self.overshoot, out)

    def reading(self, clock: float, rng: np.random.Generator) -> tuple[RobotState, bool]:
        """A reading, and whether the gate may move on it."""
        fields = {
            "stamp": clock,
            "oTb": SE3.Identity(),
            "base_twist": self.base,
            "q": self.q,
            "qd": self.qd,
            "gripper_width": 0.05,
            "gripper_moving": False,
        }
        lie = rng.random()
        if lie < 0.03:
            fields["q"] = np.where(rng.random(7) < 0.3, NAN, self.q)
            return RobotState(**fields), not np.isnan(fields["q"]).any()
        wrong = {0.04: ("stamp", clock + 100.0), 0.05: ("stamp", NAN), 0.06: ("qd", np.zeros(3))}
        wrong |= {0.07: ("stamp", clock - 0.2), 0.08: ("q", self.q + 9.0)}
        for share, (name, value) in wrong.items():
            if lie < share:
                return RobotState(**fields | {name: value}), False
        return RobotState(**fields), True


def random_command(rng: np.random.Generator, applied: Command) -> Command:
    """Anything: lawful changes, steps, far too fast, not finite."""
    kind = rng.random()
    if kind < 0.6:  # pushes in one direction as hard as it may
        push = np.sign(rng.standard_normal(7)) * LIMITS.qdd * DT
        qd = np.clip(applied.qd + push, -LIMITS.qd, LIMITS.qd)
        base = applied.base_twist + rng.choice([-1, 0, 1], 3) * LIMITS.base_acceleration * DT
        return Command(base_twist=np.clip(base, -1, 1) * [1, 0, 1], qd=qd)
    if kind < 0.9:
        return Command(
            base_twist=rng.standard_normal(3) * [1, 0, 1], qd=rng.standard_normal(7) * LIMITS.qd
        )
    bad = rng.choice([np.nan, np.inf, -1e300, 1e-310])
    return Command(base_twist=np.zeros(3), qd=np.where(rng.random(7) < 0.5, bad, 0.0))


def run_stream(seed: int) -> None:
    rng = np.random.default_rng(seed)
    plant, clock = Plant(rng), 0.0
    gate = Gate(plant, FRANKIE, DT)
    persistent = random_command(rng, gate.applied)
    previous, sent_at, stepped = Command.stop(7), 0.0, False
    for _ in range(int(rng.integers(20, 90))):
        state, believable = plant.reading(clock, rng)
        command = persistent if rng.random() < 0.3 else random_command(rng, gate.applied)
        if rng.random() < 0.1:
            persistent = command
        if rng.random() < 0.5:  # keep pushing where it went before
            qd = np.clip(gate.applied.qd * 1.0 + np.sign(gate.applied.qd) * 0.06, -2.17, 2.17)
            command = Command(base_twist=gate.applied.base_twist, qd=qd)
        try:
            applied = gate.send(command, state, clock)
        except UntrustedRobotError:
            break
        assert applied.is_finite()
        assert (np.abs(applied.qd) <= LIMITS.qd * (1 + 1e-5)).all()
        assert (np.abs(applied.base_twist) <= LIMITS.base_twist * (1 + 1e-5) + 1e-9).all()
        elapsed = plant.time - sent_at
        if stepped or elapsed > 3.0 * DT:  # it may have begun to stop by itself: as it is measured
            previous = Command(base_twist=plant.base, qd=plant.qd)
        window = elapsed + 2.0 * DT
        braked = np.abs(applied.base_twist) <= np.abs(previous.base_twist) + 1e-9
        allowed = np.where(braked, LIMITS.base_emergency, LIMITS.base_acceleration) * window
        stops = stepped and not (applied.qd.any() or applied.base_twist.any())
        if (believable or elapsed <= 3.0 * DT) and not stops:
            assert (np.abs(applied.qd - previous.qd) <= LIMITS.qdd * window + 1e-6).all()
            assert (np.abs(applied.base_twist - previous.base_twist) <= allowed + 1e-6).all()
        if not believable:
            assert (np.abs(applied.qd) <= np.abs(previous.qd) + 1e-9).all()
            assert (np.abs(applied.base_twist) <= np.abs(previous.base_twist) + 1e-9).all()
        previous, sent_at = applied, plant.time
        gap = rng.choice([DT, DT, DT, DT, 0.0, 0.003, 0.017, 0.025, 0.08, 0.5])
        plant.advance(gap)
        step = rng.choice([0.0] * 400 + [10.0, -10.0, 0.7, -0.7])
        clock, stepped = clock + gap + step, step != 0.0
        assert plant.overshoot < 1e-6, f"seed {seed}: {plant.overshoot:.4f} rad out of range"
    plant.advance(1.0)
    assert plant.overshoot < 1e-6, f"seed {seed}: {plant.overshoot:.4f} rad out of range at rest"


def test_random_streams_keep_every_limit():
    for seed in range(60):
        run_stream(seed)
