"""The staged cases of `bench untruth`: tasks, scenes, and what is true in the end."""

from collections.abc import Callable
from functools import partial
from typing import Any, TypeAlias

import numpy as np

from lab.bench import untruth_events as happens
from lab.bench.untruth import Case, Do, Staged
from lab.bench.untruth_events import BOX

Truly: TypeAlias = Callable[[Staged], bool]
Body: TypeAlias = dict[str, Any]

PLACES = """
poses:
  above: {xyz: [1.535, 0.0, 0.85], rpy_deg: [180, 0, 0], on: container}
  over_bench: {xyz: [1.335, -1.2, 0.95], rpy_deg: [180, 0, 0], on: bench}
  at_table: {xyz: [0.0, 1.40, 0.85], rpy_deg: [180, 0, 90], on: table}
  here: {xyz: [0.1, 1.6, 0.5], rpy_deg: [180, 0, 30]}
  here_on_it: {xyz: [0.1, 1.6, 0.5], rpy_deg: [180, 0, 30], on: table}
  to_person: {xyz: [0.8, 0.5, 1.0], rpy_deg: [180, -60, 90]}
regions:
  box: {centre: [1.6, 0.0, 0.556], size: [0.44, 0.36, 0.20], on: container}
  spot: {centre: [1.4, -1.2, 0.6], size: [0.3, 0.3, 0.2], on: bench}
  table: {centre: [0.0, 1.6, 0.60], size: [1.0, 0.4, 0.2], on: table}
"""
_SPOT = (1.4, -1.2, 0.6), (0.3, 0.3, 0.2)
_PERSON = 0.25  # radius [m]

# Tasks

_READY = "- recover: {arm: ready}\n"
_LOOK = _READY + "- look_at: {at: spot, distance_m: 0.5}\n"
_TRY = "- {force: success, sequence: [%s]}\n"
_SAY = 'say: {text: "counted {value}", value: $n}'
_COUNT = "".join(
    (
        _LOOK,
        _TRY % f"detect: {{region: spot, count: n}}, {_SAY}",
        _TRY % "region_empty: {region: spot}, say: {text: counted 0}",
        _TRY % f"scan_for_objects: {{region: spot, count: n}}, {_SAY}",
    )
)
_COUNT_RED = _LOOK + _TRY % f"detect: {{region: spot, count: n, colour: red}}, {_SAY}"
_EMPTY = _LOOK + "- region_empty: {region: spot}\n"
_FREE = _LOOK + "- {timeout_s: 5, until: {not: {object_visible: {within: spot}}}}\n"
_FREE_TWICE = _FREE + "- wait: {duration_s: 2}\n- not: {object_visible: {within: spot}}\n"
_GUARDED = _LOOK + "- {while: {not: {object_visible: {within: spot}}}, wait: {duration_s: 2}}\n"
_SEES_NOTHING = _LOOK + "- not: {object_visible: {within: spot}}\n"
_NOBODY = "{not: {obstacle_within: {distance_m: 0.5, sector_deg: 220}}}"
_NOBODY_NEAR = _READY + "- wait: {duration_s: 2.5}\n- " + _NOBODY + "\n"
_NOBODY_COMES = _READY + "- {while: " + _NOBODY + ", wait: {duration_s: 6}}\n"
_DRIVE = _READY + "- navigate: {to: above}\n"
_STAYS = _DRIVE + "- wait: {duration_s: 3}\n- near: {pose: above, within_m: 0.05}\n"
_FOLLOW = _READY + "- navigate: {to: over_bench}\n- follow: {within: spot, still_s: 1.5}\n"
_FETCH = _DRIVE + "- open_gripper\n- grasp: {within: box}\n- retreat_check\n"
_BRING = _FETCH + "- navigate: {to: at_table}\n- place: {on: table}\n"
_BRING_RED = _BRING.replace("within: box", "within: box, colour: red")
_BRING_HERE = _BRING.replace("on: table", "at: here")
_STACK = _FETCH + "- navigate: {to: over_bench}\n- place: {onto: spot}\n"
_BRING_ALL = (
    _READY
    + """- until:
    - sequence: [navigate: {to: above, within_m: 0.15}, open_gripper, region_empty: {region: box}]
    - {retry: 3, sequence: [recover, navigate: {to: above}, open_gripper, grasp: {within: box},
       retreat_check]}
    - navigate: {to: at_table, within_m: 0.15}
    - place: {on: table}
- all_placed: {taken_from: box}
"""
)
_GIVE = _FETCH + "- hand_over: {at: to_person, timeout_s: 4}\n"
_TAKE = _READY + "- receive: {at: to_person, every_s: 0.5, timeout_s: 5}\n"


def _in_box(task: str) -> str:
    return task.replace("spot", "box")


# Scenes


def _thing(name: str, edges: tuple[int, int, int], x: float, y: float, **more: object) -> Body:
    """A box [mm] at x and y from the middle of what it stands on [m]."""
    return {"name": name, "box": edges, "at": (x, y), "mass_g": 100, **more}


def _room(*inside: Body, bench: tuple[Body, ...] = (), **more: Any) -> Body:
    """A container with things in it, a bench and a table."""

    def items(things: tuple[Body, ...], middle: tuple[float, float]) -> Body:
        placed = [one | {"at": np.add(one["at"], middle).tolist()} for one in things]
        return {"items": placed, "count": 0}

    on_bench = {"name": "bench", "centre": _SPOT[0][:2], "size": (0.7, 0.6)}
    on_bench |= {"objects": items(bench, _SPOT[0][:2])} | more.pop("moving", {})
    tables = {"table": {"centre": (0.0, 1.6)}, "side_tables": [on_bench]}
    return (
        {"container": {"centre": BOX[0][:2]}, "objects": items(inside, BOX[0][:2])} | tables | more
    )


def _walks(*way: tuple[float, float], speed: float = 0.6) -> Body:
    return _room(walkers=[{"name": "Ada", "way": way, "speed": speed, "radius": _PERSON}])


_CUBE = (25, 25, 25)
_THING = _thing("thing", (40, 40, 60), -0.02, 0.02)
_BELOW = _thing("below", (70, 70, 40), 0.0, 0.0)
_ONE, _TWO = _room(_THING), _room(_THING, _thing("other", (40, 40, 60), 0.1, -0.1))
_SOMEBODY = _walks((0.95, 0.0), (0.95, 0.02), speed=0.01)
_RED_BLUE = _room(
    _thing("red", (40, 50, 50), -0.08, 0.08, colour="red"),
    _thing("blue", (40, 50, 50), 0.08, -0.08, colour="blue"),
)
_PAIR = _room(_thing("a", (40, 40, 40), 0.0, 0.021), _thing("b", (40, 40, 40), 0.0, -0.0195))
_CARDS = [_thing(f"card{n}", (60, 40, 6), 0.12 * n - 0.12, -0.12) for n in range(3)]


def _row(y: float) -> list[Body]:
    return [_thing(f"cube{n}", _CUBE, 0.04 * n - 0.14, y) for n in range(8)]


# What is true


def _here(*shifts: float) -> Truly:
    """Whether the object is within 35 mm of `here`, or of that place moved along x [m]."""
    return lambda run: any(
        np.linalg.norm(run.place("thing")[:2] - [0.1 + shift, 1.6]) < 0.035 for shift in shifts
    )


def _stacked(run: Staged) -> bool:
    x, y, z = run.place("thing") - run.place("below")
    return bool(np.hypot(x, y) < 0.03 and z > 0.04)


def _nobody_is_near(run: Staged) -> bool:
    half = np.array(run.setup.robot.description.base.size[:2]) / 2.0
    away = (np.abs((one.pose.translation - run.base)[:2]) - half for one in run.world.walkers)
    return all(np.linalg.norm(np.maximum(way, 0.0)) > 0.5 + _PERSON for way in away)


def _believed(run: Staged) -> bool:
    """Whether the base is within 0.1 m of where the robot believes."""
    here = run.setup.context.to_map(run.setup.context.state.oTb).translation
    return bool(np.linalg.norm(here - run.base) < 0.1)


def _case(usual: str, name: str, at: str = "", do: Do | None = None, **more: Any) -> Case:
    return Case(**{"name": name, "task": usual, "at": at, "do": do, "scene": _ONE} | more)


_asked = partial(_case, _in_box(_COUNT), count=lambda run: run.inside(*BOX))
_bench = partial(_case, _COUNT, count=lambda run: run.inside(*_SPOT))
_false = partial(_case, true=lambda run: False)
_nobody = partial(_case, _NOBODY_NEAR, true=_nobody_is_near, scene=_SOMEBODY)
_drives = partial(
    _case, _DRIVE, true=lambda run: bool(np.linalg.norm(run.hand - [1.535, 0.0, 0.85]) < 0.05)
)
_brings = partial(_case, _BRING, true=lambda run: run.on("table", "thing"))
_exactly = partial(_case, _BRING_HERE, true=_here(0.0))
_stacks = partial(_case, _STACK, true=_stacked, scene=_room(_THING, bench=(_BELOW,)))
_all = partial(_case, _BRING_ALL, true=lambda run: run.on("table"))
_gives = partial(_case, _GIVE, true=lambda run: bool(np.linalg.norm(run.place("thing")) > 5.0))
_takes = partial(_case, _TAKE, true=lambda run: run.held is not None)

_SET_DOWN = happens.put("thing", *_SPOT[0])
_LAMP = {"name": "lamp", "centre": (1.5, -1.1, 0.8), "size": (0.1, 0.1, 0.05)}
_SWINGS = {"motion": {"along": (0.12, 0.0), "period_s": 6.0}}
_WIDER = happens.width(lambda run, w: w + 0.002)
_TABLE_OFF = {"table": (0.08, 0.0, 0.0)}

CASES = (
    # How many?
    _asked("empty container", scene=_room()),
    _asked("row along the wall", scene=_room(*_row(0.166))),
    _asked("bar along the wall", scene=_room(_thing("bar", (300, 24, 24), 0.0, 0.167))),
    _asked("mat on the floor", scene=_room(_thing("mat", (425, 345, 14), 0.0, 0.0))),
    _asked("cards beside a box", scene=_room(_thing("high", (40, 40, 60), 0.0, 0.1), *_CARDS)),
    _asked("card of 9 mm", scene=_room(_thing("card", (60, 40, 9), 0.0, 0.0))),
    _asked("two that touch", scene=_PAIR, beyond="two that touch look like one, and none fell"),
    _asked(
        "behind a tall one",
        scene=_room(_thing("tall", (80, 80, 120), 0.0, 0.0), _thing("cube", _CUBE, 0.07, 0.0)),
    ),
    _asked(
        "container moved",
        scene=_room(_thing("cube", _CUBE, 0.2, 0.16)),
        moved={"container": (0.07, 0.05, 2.0)},
        count=lambda run: 1,  # its inside is where it stands
    ),
    _asked("without depth", "recover", happens.depth(happens.without_depth)),
    _asked(
        "dirty lens",
        "recover",
        happens.depth(happens.dirty),
        scene=_room(_thing("cube", _CUBE, 0.15, 0.12)),
    ),
    _bench("row on the bench", scene=_room(bench=(*_row(0.13),))),
    _bench("book over the region", scene=_room(bench=(_thing("book", (320, 320, 14), 0.0, 0.0),))),
    _case(
        _in_box(_COUNT_RED),
        "red behind a tall one",
        scene=_room(
            _thing("tall", (80, 80, 120), 0.1, 0.0, colour="blue"),
            _thing("red", (15, 20, 10), 0.16, 0.0, colour="red"),
        ),
        count=lambda run: 1,
    ),
    # What does it see?
    _false(
        _EMPTY + _in_box(_EMPTY),
        "frozen on the way",
        "region_empty+0.1",
        happens.fault("picture frozen"),
    ),
    _false(_in_box(_SEES_NOTHING), "dark", "look_at+0.2", happens.fault("frames black")),
    _false(_FREE_TWICE, "set down meanwhile", "wait+0.5", _SET_DOWN),
    _false(
        _FREE_TWICE,
        "set down, frozen",
        "wait+0.5",
        happens.both(happens.fault("picture frozen"), _SET_DOWN),
        beyond="one picture cannot show that the camera hangs",
    ),
    _false(_GUARDED, "set down below a guard", "wait+0.5", _SET_DOWN),
    _false(
        _FREE,
        "below a lamp",
        scene=_room(bench=(_thing("cube", _CUBE, 0.13, 0.13),), fixtures=[_LAMP]),
    ),
    _nobody("nobody near", scene=_ONE),
    _nobody("somebody near"),
    _nobody("laser covered", "recover", happens.beams(np.nan)),
    _nobody("laser tells 0", "recover", happens.beams(0.0)),
    _nobody(
        "scan frozen",
        "wait+0.5",
        happens.scan_frozen,
        scene=_walks((2.6, 0.6), (0.9, 0.2), speed=1.0),
        true=lambda run: False,
    ),
    _false(_NOBODY_COMES, "somebody comes", scene=_walks((2.6, -0.5), (0.9, 0.0))),
    # Where is it?
    _case(
        _LOOK + "- localised: {within_m: 0.1}\n",
        "carried off before it is asked",
        "look_at+0.3",
        happens.shove(0.4, 0.3),
        true=_believed,
    ),
    _drives("carried off on the way", "navigate+0.5", happens.shove(0.4, 0.3)),
    _drives("pushed on the way", "navigate+0.5", happens.shove(0.05, 0.03, 4.0, lifted=False)),
    _drives("localisation jumps", "navigate+0.5", happens.fault("localisation jump")),
    _drives("carried off when it is there", "wait+0.2", happens.shove(-0.25, 0.1), task=_STAYS),
    _case(
        _READY + "- drive: {forward_m: 0.5}\n",
        "held back on the way",
        "drive+0.8",
        happens.shove(-0.2, 0.0),
        true=lambda run: bool(abs(run.base[0] - 0.5) < 0.06),
    ),
    _false(
        _FOLLOW,
        "follows a frozen picture",
        "follow+1.0",
        happens.fault("picture frozen"),
        scene=_room(bench=(_thing("thing", (40, 40, 60), 0.0, 0.0),), moving=_SWINGS),
    ),
    # Does it stand there?
    _brings("nothing happens"),
    _brings("taken on the way", "carry+0.5", happens.put("thing")),
    _brings(
        "taken on the way, fingers stuck",
        "carry+0.5",
        happens.both(happens.stops(), happens.put("thing")),
    ),
    _brings("slips on the way", "carry+0.8", Staged.slip),
    _brings("slips while lowered", "lower+0.05", Staged.slip),
    _brings(
        "taken while lowered, fingers stuck",
        "lower+0.05",
        happens.both(happens.stops(), happens.put("thing")),
    ),
    _brings(
        "knocked off late", "rise+0.45", happens.lose, beyond="it fell after it was seen to stand"
    ),
    _brings("sticks to a finger", "release", happens.sticks),
    _brings("closes on dirt", "close", happens.both(happens.gone, happens.stops(0.012))),
    _brings("closes on nothing, 2 mm off", "close", happens.both(happens.gone, _WIDER)),
    _exactly("pushed while it lowers", "lower+0.1", happens.shove(0.05, 0.0, 4.0, lifted=False)),
    _exactly("pushed aside in the rise", "rise+0.2", happens.put("thing", 0.16, 1.63, 0.56)),
    _exactly(
        "table moved",
        moved=_TABLE_OFF,
        true=_here(0.0, 0.08),
        beyond="the table alone is in sight, and it says so",
    ),
    _exactly(
        "table moved, place on it",
        task=_BRING_HERE.replace("here", "here_on_it"),
        moved=_TABLE_OFF,
        true=_here(0.08),
    ),
    _case(
        _BRING_RED,
        "swapped",
        "descend",
        happens.swap,
        scene=_RED_BLUE,
        true=lambda run: run.on("table", "red"),
    ),
    _stacks("stacked"),
    _stacks("slides off the stack", "rise+0.2", happens.put("thing", 1.2, -1.2, 0.6)),
    _stacks("pulled from below", "lower+0.2", happens.put("below", 1.2, -1.2, 0.6)),
    # Are they all there?
    _all("one of two that touch is lost", "carry+0.3", happens.lose, scene=_PAIR),
    _all("bar left at the wall", scene=_room(_THING, _thing("bar", (300, 24, 24), 0.0, 0.167))),
    _all("one falls back, the other is lost", "retreat+0.3", happens.first_back, scene=_TWO),
    # People
    _gives("a person takes it", "offer+0.5", happens.fault("object pulled")),
    _gives("nobody takes it"),
    _gives("bumped", "offer+1", happens.felt(happens.width(lambda run, w: w + 0.0012), 0.05)),
    _gives(
        "noise of the width", "offer", happens.width(lambda run, w: w + run.rng.normal(0.0, 0.0003))
    ),
    _gives("slips while held out", "offer+1", Staged.slip),
    _gives("touched and dropped", "offer+1", happens.felt(_WIDER, 0.3, Staged.slip)),
    _gives("the width creeps", "offer", happens.creeps),
    _takes("a person gives", "offer+0.2", happens.fault("object given")),
    _takes("nobody gives"),
    _takes("a person gives, and takes", "offer+0.2", happens.given_and_taken),
    _takes("dirt between the fingers", "recover", happens.stops(0.012)),
    _takes("width 2 mm off", "recover", _WIDER),
    _takes("fingers stop half way", "offer", happens.fault("gripper halfway")),
    _takes("a finger", "offer+0.3", happens.finger),
)
