"""Random damage to the folder of a real run: `explain` and `runs` tell about it or refuse it."""

import io
import json
import random
import shutil

import pytest

from app.core.launch import run_task
from app.core.run_options import RunOptions
from app.review import explain, read_run, runs_table
from app.terminal import Terminal
from config import UserError

TASK = """\
task: toy
poses:
  near: {xyz: [0.9, 0.1, 0.7], rpy_deg: [180, 0, 0]}
tree:
  sequence:
    - wait: {duration_s: 0.05}
    - retry: 2
      navigate: {to: near, timeout_s: 0.1}
"""
ODD = (
    None, True, 0, -1, 7, 10**6, 10**400, 0.5, -0.0, 1e308, float("nan"), float("inf"), "", "x",
    "\x1b[2J", "\ud800", "begin", "end", "RUNNING", "a" * 10_000, [], [1], {}, {"a": 1}, [[[]]],
)  # fmt: skip


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    root = tmp_path_factory.mktemp("recorded")
    (root / "toy.yaml").write_text(TASK)
    return run_task(RunOptions(tree=root / "toy.yaml", scene="single", record=root)).folder


def places(value, so_far=()):
    """Every place in a JSON value, as keys and indices."""
    yield so_far
    inner = value.items() if isinstance(value, dict) else []
    inner = enumerate(value) if isinstance(value, list) else inner
    for key, one in inner:
        yield from places(one, (*so_far, key))


def mutated(value, rng: random.Random):
    """A JSON value with one place replaced, removed or renamed."""
    *way, last = rng.choice([place for place in places(value) if place] or [(None,)])
    if last is None:
        return rng.choice(ODD)
    holder = value
    for key in way:
        holder = holder[key]
    match rng.randrange(4):
        case 0:
            del holder[last]
        case 1 if isinstance(holder, dict):
            holder[str(rng.choice(ODD))] = holder.pop(last)
        case _:
            holder[last] = rng.choice(ODD)
    return value


def damaged_text(text: str, rng: random.Random) -> bytes:
    """A file of JSON lines with some damage to its values, its lines or its bytes."""
    lines = text.splitlines()
    for _ in range(rng.choice((1, 1, 2, 5))):
        number = rng.randrange(len(lines))
        match rng.randrange(6):
            case 0:
                lines.insert(rng.randrange(len(lines)), lines[number])
            case 1 if len(lines) > 1:
                del lines[number]
            case 2:
                lines[number] = lines[number][: rng.randrange(len(lines[number]) + 1)]
            case _:
                try:
                    lines[number] = json.dumps(mutated(json.loads(lines[number]), rng))
                except ValueError:
                    lines[number] = "{"
    data = bytearray(("\n".join(lines) + "\n").encode("utf-8", "surrogatepass"))
    if rng.random() < 0.2:
        for _ in range(rng.randrange(1, 9)):
            data[rng.randrange(len(data))] = rng.randrange(256)
    return bytes(data)


def survive(run, folder, cases: range) -> dict[str, int]:
    """Damages a copy of the run in many ways; counts what came of it."""
    shutil.copytree(run, folder)
    counts = {"explained": 0, "refused": 0}
    events = (run / "events.jsonl").read_text(encoding="utf-8")
    summary = json.dumps(json.loads((run / "summary.json").read_text()))
    for seed in cases:
        rng = random.Random(seed)
        (folder / "events.jsonl").write_bytes(
            damaged_text(events, rng) if rng.random() < 0.8 else events.encode()
        )
        (folder / "summary.json").write_bytes(damaged_text(summary, rng))
        told = io.StringIO()
        terminal = Terminal(file=told, width=200)
        try:
            terminal.say(str(explain(folder)))
            counts["explained"] += 1
        except UserError as refused:
            counts["refused"] += "\n" not in str(refused)
            terminal.say(str(refused))
        record = read_run(folder)
        terminal.print(runs_table([record]))
        text = told.getvalue()
        assert all(letter.isprintable() or letter in "\n\t" for letter in text), seed
        text.encode("utf-8")
    return counts


def test_random_damage_is_told_or_refused(run, tmp_path):
    counts = survive(run, tmp_path / "copy", range(100))
    assert sum(counts.values()) == 100
    assert min(counts.values()) > 10  # both happen


@pytest.mark.slow
def test_much_random_damage_is_told_or_refused(run, tmp_path):
    counts = survive(run, tmp_path / "copy", range(400, 10_400))
    assert sum(counts.values()) == 10_000
