"""Ways in which the folder of a run can be damaged, by the file that they are about."""

import json
import os
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

Damage = Callable[[Path], object]

EVENTS, SUMMARY, STATES = "events.jsonl", "summary.json", "states.npy"


class Bomb:
    """Makes a file when it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


def replaced(content: bytes | str) -> Damage:
    data = content.encode() if isinstance(content, str) else content
    return lambda path: path.write_bytes(data)


def a_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


def a_link_to_itself(path: Path) -> None:
    path.unlink()
    path.symlink_to(path)


def a_link_to(target: str) -> Damage:
    return lambda path: (path.unlink(), path.symlink_to(target))


def a_pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


def line(number: int, **fields: object) -> Damage:
    """Changes fields of one line of the log; None takes the field out."""

    def damage(path: Path) -> None:
        lines = path.read_text().splitlines()
        read = json.loads(lines[number])
        read |= fields
        lines[number] = json.dumps({key: v for key, v in read.items() if v is not None})
        path.write_text("\n".join(lines) + "\n")

    return damage


def raw_line(number: int, text: str) -> Damage:
    def damage(path: Path) -> None:
        lines = path.read_text().splitlines()
        lines[number] = text
        path.write_text("\n".join(lines) + "\n")

    return damage


def moved(number: int, to: int) -> Damage:
    def damage(path: Path) -> None:
        lines = path.read_text().splitlines()
        lines.insert(to, lines.pop(number))
        path.write_text("\n".join(lines) + "\n")

    return damage


def value(**fields: object) -> Damage:
    """Changes fields of the summary."""

    def damage(path: Path) -> None:
        path.write_text(json.dumps(json.loads(path.read_text()) | fields))

    return damage


def array(make: Callable[[np.ndarray], np.ndarray]) -> Damage:
    return lambda path: np.save(path, make(np.load(path)))


def pickled(path: Path) -> None:
    np.save(path, np.array([Bomb(path.parent / "ran")] * 3, dtype=object), allow_pickle=True)


def first_half(path: Path) -> None:
    data = path.read_bytes()
    path.write_bytes(data[: len(data) // 2])


ANY_FILE: Mapping[str, Damage] = {
    "missing": Path.unlink,
    "empty": replaced(""),
    "random bytes": replaced(np.random.default_rng(0).bytes(5000)),
    "a folder": a_folder,
    "a link to itself": a_link_to_itself,
    "a link to an endless device": a_link_to("/dev/zero"),
    "a pipe": a_pipe,
    "a list": replaced("[1, 2]"),
    "null": replaced("null"),
    "nested deep": replaced("[" * 100_000),
    "another program's": replaced('{"version": 3, "event": {"begin": []}}\n'),
}
"""Of any file of text."""

EVENT_DAMAGE: Mapping[str, Damage] = {
    **ANY_FILE,
    "begin without nodes": line(0, nodes=None),
    "begin in the middle": moved(0, 3),
    "begin twice": raw_line(2, '{"event": "begin", "time": 0, "nodes": '
                            '[{"path": "a", "name": "a", "kind": "a"}]}'),
    "end in the middle": moved(-1, 3),
    "a node out of range": line(2, event="node", node=99, status="RUNNING", message=""),
    "an unknown status": line(2, event="node", node=0, status="DONE", message=""),
    "a message that is a list": line(2, event="now", node=0, message=["a"]),
    "a time that is text": line(3, time="3"),
    "a time that is no number": line(3, time=float("nan")),
    "values that are text": line(-1, values={"goal distance [m]": "near"}),
    "a value with 400 digits": line(-1, values={"goal distance [m]": 10**400}),
    "a pause without a why": line(2, event="pause", why=None),
    "an unknown end": line(-1, outcome="glory"),
    "an end at no such node": line(-1, node=1000),
}  # fmt: skip

SUMMARY_DAMAGE: Mapping[str, Damage] = {
    **{name: damage for name, damage in ANY_FILE.items() if name != "missing"},
    "truncated": first_half,
    "no outcome": replaced("{}"),
    "a duration that is text": value(duration_s="abc"),
    "a duration that is endless": replaced('{"outcome": "success", "duration_s": 1e999}'),
    "placed below zero": value(placed=-3),
    "objects with 400 digits": replaced('{"outcome": "success", "objects": ' + "1" * 400 + "}"),
    "a seed that is text": value(seed="0"),
}  # fmt: skip

ARRAY_DAMAGE: Mapping[str, Damage] = {
    **{name: damage for name, damage in ANY_FILE.items() if "nested" not in name},
    "half a header": lambda path: path.write_bytes(path.read_bytes()[:40]),
    "pickled code": pickled,
    "three columns": array(lambda a: a[:, :3]),
    "one tick": array(lambda a: a[:1]),
    "a scalar": array(lambda a: np.array(1.0)),
    "texts": array(lambda a: a.astype(str)),
    "single precision": array(lambda a: a.astype(np.float32)),
    "not a number": array(lambda a: np.full_like(a, np.nan)),
    "an archive": lambda path: np.savez(path.open("wb"), a=np.zeros(3)),
    "a header of a petabyte": replaced(
        b"\x93NUMPY\x01\x00v\x00{'descr': '<f8', 'fortran_order': False, "
        b"'shape': (9999999999999, 22), }".ljust(127) + b"\n"
    ),
    "a header that is code": replaced(
        b"\x93NUMPY\x01\x00v\x00__import__('os').system('true')".ljust(127) + b"\n"
    ),
}  # fmt: skip
"""Of any array."""

STATES_DAMAGE: Mapping[str, Damage] = {
    **ARRAY_DAMAGE,
    "stamps that stand still": array(lambda a: np.zeros_like(a)),
    "stamps that run back": array(lambda a: a[::-1]),
    "stamps an hour apart": array(lambda a: a * 3.6e5),
}


def damaged(folder: Path, to: Path, file: str, damage: Damage) -> Path:
    """A copy of a run with one of its files damaged."""
    copy = to / folder.name
    shutil.rmtree(copy, ignore_errors=True)
    shutil.copytree(folder, copy)
    damage(copy / file)
    return copy
