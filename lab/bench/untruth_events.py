"""What happens in the staged cases of `bench untruth`: to things, base, sensors, and by people."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from pinocchio import SE3

from config.arrays import Array
from hw import DepthFrame, LaserScan, RobotState
from lab.bench.untruth import Do, Staged

BOX = (1.6, 0.0, 0.556), (0.44, 0.36, 0.2)  # middle and size of the inside of the container [m]
ON_FLOOR = (2.5, 1.3, 0.1)  # beside all furniture and ways [m]


def put(name: str, *xyz: float) -> Do:
    """Somebody moves an object, or takes it away."""
    return lambda run: run.put(name, *xyz)


def lose(run: Staged) -> None:
    """What is held is on the floor."""
    run.put(run.held or "thing", *ON_FLOOR)


def gone(run: Staged) -> None:
    """What is nearest to the hand is taken."""
    names = [one.name for one in run.world.objects]
    run.put(min(names, key=lambda name: float(np.linalg.norm(run.place(name) - run.hand))))


def shove(x: float, y: float, deg: float = 0.0, *, lifted: bool = True) -> Do:
    """The base is pushed, or lifted and set down elsewhere."""
    return lambda run: run.shove(x, y, deg, lifted=lifted)


def fault(name: str) -> Do:
    """A fault on request."""
    return lambda run: run.inject(name)


def both(*several: Do) -> Do:
    """One after the other."""
    return lambda run: [one(run) for one in several]


def tell(sensor: str, change: Callable[[Staged, Any], Any]) -> Do:
    """A sensor tells something else from now on: `reading`, `picture` or `scan`."""
    return lambda run: setattr(run, sensor, partial(change, run))


def width(change: Callable[[Staged, float], float]) -> Do:
    """The fingers tell another width [m]."""

    def told(run: Staged, state: RobotState) -> RobotState:
        return replace(state, gripper_width=max(0.0, change(run, state.gripper_width)))

    return tell("reading", told)


def stops(at: float | None = None) -> Do:
    """The fingers close no further than a width, or than now, as on dirt [m]."""

    def do(run: Staged) -> None:
        least = run.setup.context.state.gripper_width if at is None else at
        run.reading = lambda state: (
            state
            if state.gripper_width >= least
            else replace(state, gripper_width=least, gripper_moving=False)
        )

    return do


def creeps(run: Staged) -> None:
    """The width drifts by 0.3 mm/s."""
    begun = run.now
    width(lambda run, w: w - 0.0003 * (run.now - begun))(run)


def felt(change: Do, seconds: float, then: Do = lambda run: None) -> Do:
    """The width changes for a time."""

    def do(run: Staged) -> Iterator[None]:
        change(run)
        yield from run.wait(seconds)
        width(lambda run, w: w)(run)
        then(run)

    return do


def finger(run: Staged) -> Iterator[None]:
    """A person's finger is between the fingers when they close."""
    yield from run.enter("fingers")
    yield from felt(stops(0.017), 0.8)(run)


def depth(change: Callable[[Staged, DepthFrame], Array]) -> Do:
    """The camera tells other depths."""
    return tell(
        "picture", lambda run, frame: replace(frame, depth=change(run, frame).astype(np.float32))
    )


def without_depth(run: Staged, frame: DepthFrame) -> Array:
    """Of what stands in the container, as if it were black or shiny."""
    k, z, eye = frame.intrinsics, frame.depth.astype(float), run.camera
    v, u = np.indices(z.shape)
    seen = np.stack([(u - k.cx) / k.fx * z, (v - k.cy) / k.fy * z, z], axis=-1)
    off = np.abs(seen @ eye.rotation.T + eye.translation - BOX[0] - [0.0, 0.0, -0.01])
    return np.where(np.all(off < [0.2, 0.16, 0.08], axis=-1), np.nan, z)


def dirty(run: Staged, frame: DepthFrame) -> Array:
    """A quarter of the picture is without depth."""
    row, column = np.indices(frame.depth.shape) * 2
    hidden = (row < frame.depth.shape[0]) & (column < frame.depth.shape[1])
    return np.where(hidden, np.nan, frame.depth)


def beams(value: float) -> Do:
    """Two thirds of the beams of the laser tell one value."""

    def told(run: Staged, scan: LaserScan) -> LaserScan:
        hit = np.arange(len(scan.ranges)) * 3 < 2 * len(scan.ranges)
        ranges = np.where(hit, value, scan.ranges)
        laser = run.setup.robot.description.laser
        return replace(scan, ranges=ranges, points=laser.points(ranges) if laser else scan.points)

    return tell("scan", told)


def scan_frozen(run: Staged) -> None:
    """The laser repeats one scan, with fresh stamps."""
    if (first := run.setup.robot.laser.latest(np.inf)) is not None:
        run.scan = lambda scan: replace(scan, ranges=first.ranges, points=first.points)


def swap(run: Staged) -> None:
    """Red and blue change places."""
    red, blue = run.place("red"), run.place("blue")
    run.put("red")
    run.put("blue", *red)
    run.put("red", *blue)


def given_and_taken(run: Staged) -> Iterator[None]:
    """A person gives something, and takes it back."""
    run.inject("object given")
    while (held := run.held) is None:
        yield
    yield from run.wait(0.3)
    run.put(held)


def sticks(run: Staged) -> Iterator[None]:
    """It sticks to a finger that opens, and falls beside the table."""
    one, way = run.find("thing"), run.place("thing") - run.hand
    for _ in range(60):
        yield
        one.pose = SE3(one.pose.rotation, run.hand + way)  # `put` would let it fall
    run.put("thing", *ON_FLOOR)


def first_back(run: Staged) -> None:
    """The held one falls back, the other one is lost."""
    other = "other" if (run.held or "").startswith("thing") else "thing"
    run.slip()
    run.put(other, *ON_FLOOR)
