"""Ablation: a mechanism is taken away, or a number changed, and the same trials run once more.

    python -m lab.bench.ablation lab/bench/mechanisms.yaml --results ablation.jsonl --seeds 0-4

Each change lives in a copy of the product. Its room says what is tried: grasps of many scenes,
worlds with obstacles, or whole tasks. What has run of the last commit is kept in the file of
results, one trial a line, and does not run again: it can be stopped, and more seeds added later.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from shutil import copytree, ignore_patterns
from tempfile import TemporaryDirectory, mkdtemp
from typing import Annotated, Any, TypeAlias

import numpy as np
import typer
import yaml

from lab.bench.commands.bench_options import Cluster, Seeds, Workers, seed_range, show
from lab.shared import paired_difference, progress, run_all, table

Trial: TypeAlias = tuple[str, int]
"""Words of `frankie-task`, and the seed."""
Units: TypeAlias = list[dict[str, float]]
"""Figures of a run, or of each of the worlds or scenes of one command; a larger one is worse."""
Figures: TypeAlias = dict[tuple[str, str, int], Units]
"""Of trials, by mechanism, words and seed."""

AS_IS = "as it is"
TASKS = (  # each a few seconds of a processor
    "run pick_one --world physics",
    "run pick_one --scene shapes --localisation poor",
    "run trees/lessons/fetch_one.yaml --scene corridor",
)
LONG_TASKS = (
    "run trees/lessons/collect.yaml",
    "run follow_moving_object",
    "run clear_counter --world physics",
    "run clear_bar",
    "run restock_shelf --world physics",
    "run pick_place --localisation poor",
)
_WORLDS = "bench obstacles --robot frankie --controller frankie --count 10"
TRIALS = {  # by the beginning of the path of a mechanism; the first that fits
    "perception/grasps/scene_memory": TASKS,
    "perception/grasps/tracker": TASKS,
    "perception/grasps": ("grasp eval --tilts 0,45,90 --scenes 30",),
    "perception/networks": ("grasp eval --tilts 0,45,90 --scenes 30",),
    "controller/stance/moving_goal": ("run follow_moving_object",),
    "controller/stance": (_WORLDS, "run restock_shelf", "run clear_counter"),
    "controller": (_WORLDS,),
}


def _of_run(run: dict[str, Any]) -> Units:
    return [
        {
            "not placed": float((run["objects"] or 0) - (run["placed"] or 0)),
            "failed": float(run["outcome"] != "success"),
            "attempts": float(run["attempts"]),
            "contacts": float(run["contacts"]),
            "seconds": float(run["duration_s"]),
        }
    ]


def _of_worlds(bench: dict[str, Any]) -> Units:
    return [
        {
            "failed": float(bool(world["reason"])),
            "contacts": float(sum(touch["avoidable"] for touch in world["touches"])),
            "seconds": world["time_s"],
        }
        for row in bench["results"]
        for world in row["worlds"]
    ]


def _of_grasps(evaluation: dict[str, Any]) -> Units:
    attempts = [one for row in evaluation["rows"] for one in row["singles"]]
    return [{"not held": float(one["end"] != "held")} for one in attempts]


_UNITS = {"run": _of_run, "bench": _of_worlds, "grasp": _of_grasps}
_FIGURES = ("failed", "not placed", "not held", "attempts", "contacts", "seconds")
_BATCH = 4  # trials in a row of one process, so that few copies are made
_LIMIT = 900.0  # of one trial, of the processor of a slow computer [s]
_CONSTANT = r"^({name}(?:: [^=\n]+)? = )([^#\n]+?)(\s*(?:#.*)?)$"


@dataclass(frozen=True, kw_only=True)
class Mechanism:
    """A change of the product."""

    name: str
    path: str  # of the file, in the repository
    find: str  # text that stands there once, or the name of a constant
    replace: str  # what stands there instead; of a constant its value
    lines: int = 0  # that would go

    def of(self, source: str) -> str:
        """The changed file; ValueError if there is nothing to change."""
        if self.find.isidentifier():
            pattern = re.compile(_CONSTANT.format(name=self.find), re.MULTILINE)
            changed, found = pattern.subn(rf"\g<1>{self.replace}\g<3>", source)
        else:
            changed, found = source.replace(self.find, self.replace), source.count(self.find)
        if found != 1:
            raise ValueError(f"{self.name}: `{self.find}` stands {found} times in {self.path}")
        return changed


@dataclass(frozen=True, kw_only=True)
class Job:
    """One trial of one mechanism, None of the product as it is."""

    mechanism: Mechanism | None
    task: str  # words of `frankie-task`
    seed: int

    @property
    def key(self) -> tuple[str, str, int]:
        """Of its line in the file of results."""
        return (self.mechanism.name if self.mechanism else AS_IS, self.task, self.seed)


def mechanisms(path: Path) -> Iterator[Mechanism]:
    """Those of a file; a constant with `times` is one for each factor of its value."""
    for entry in yaml.safe_load(path.read_text(encoding="utf-8")):
        factors = entry.pop("times", ())
        if not factors:
            yield Mechanism(**entry)
        for factor in factors:
            constant = entry["find"]
            name = f"{constant.strip('_').lower().replace('_', ' ')} x {factor:g}"
            source = Path(entry["path"]).read_text(encoding="utf-8")
            found = re.search(_CONSTANT.format(name=constant), source, re.MULTILINE)
            if found is None:
                raise ValueError(f"{entry['path']} has no constant {constant}")
            yield Mechanism(name=name, **entry, replace=f"({found[2]}) * {factor:g}")


def trials_of(change: Mechanism) -> tuple[str, ...]:
    """What is run with and without it."""
    return next((tried for path, tried in TRIALS.items() if change.path.startswith(path)), TASKS)


def run_trial(job: Job, folder: str) -> Units:
    """The figures of a trial, in a copy of the product with the change, in a folder."""
    copy = _copy(job.mechanism, folder)
    with TemporaryDirectory() as runs:
        result, words = Path(runs) / "figures.json", job.task.split()
        if words[0] == "run":
            words += ["--seed", str(job.seed), "--record", runs, "--json"]
        else:
            words += ["--workers", "1", "--json", str(result)]
            words += ["--seed", str(job.seed)] if words[0] == "bench" else []
        command = [sys.executable, "-c", "from frankie_task_cli import main; main()", *words]
        environment = os.environ | {"PYTHONPATH": str(copy), "OMP_NUM_THREADS": "1"}
        ended = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, timeout=_LIMIT, check=False
        )
        written = result.read_text(encoding="utf-8") if result.exists() else ended.stdout
        try:
            return _UNITS[words[0]](json.loads(written))
        except json.JSONDecodeError:
            raise RuntimeError(f"{job.key}: {ended.stderr.decode()[-600:]}") from None


@lru_cache(maxsize=2)
def _copy(change: Mechanism | None, folder: str) -> Path:
    """The product with a change, of this process; where it is the same, so is its byte code."""
    Path(folder).mkdir(exist_ok=True)  # on another computer of a cluster it is not there yet
    product = Path(mkdtemp(dir=folder)) / "product"
    copytree(".", product, ignore=ignore_patterns(".*", "tests", "docs", "runs", "*.egg-info"))
    if change is not None:
        file = product / change.path
        file.write_text(change.of(file.read_text(encoding="utf-8")), encoding="utf-8")
    return product


@dataclass(frozen=True, kw_only=True)
class Row:
    """What a mechanism is worth."""

    name: str
    lines: int
    trials: int
    changed: int  # trials with another figure
    differences: dict[str, tuple[float, float, float]]
    """Of the figures without it, less those with it; and their 95 % intervals."""

    @property
    def verdict(self) -> str:
        """What gets worse and what better without it, beyond chance."""
        worse = [name for name, (_, low, _) in self.differences.items() if low > 0.0]
        better = [name for name, (_, _, high) in self.differences.items() if high < 0.0]
        words = (("worse: ", worse), ("better: ", better))
        return "; ".join(head + ", ".join(names) for head, names in words if names) or "-"

    def figure(self, name: str) -> str:
        """A difference and its interval."""
        if name not in self.differences:
            return ""
        return "{:+.3f} ({:+.3f} to {:+.3f})".format(*self.differences[name])


def rows(changes: Iterable[Mechanism], done: Figures) -> Iterator[Row]:
    """A row for each mechanism, over the trials that both have done."""
    before = {key[1:]: units for key, units in done.items() if key[0] == AS_IS}
    for change in changes:
        without = {key[1:]: units for key, units in done.items() if key[0] == change.name}
        pairs = [
            pair
            for trial in sorted(before.keys() & without.keys())
            for pair in zip(before[trial], without[trial], strict=True)
        ]
        if not pairs:
            continue
        yield Row(
            name=change.name,
            lines=change.lines,
            trials=len(pairs),
            changed=sum(is_now != was for was, is_now in pairs),
            differences={
                name: paired_difference(
                    np.array([is_now[name] for was, is_now in pairs if name in was]),
                    np.array([was[name] for was, _ in pairs if name in was]),
                )
                for name in _FIGURES
                if any(name in was for was, _ in pairs)
            },
        )


def _read(results: Path, commit: str) -> Figures:
    text = results.read_text(encoding="utf-8") if results.exists() else ""
    lines = [json.loads(line) for line in text.splitlines()]
    return {tuple(one["trial"]): one["figures"] for one in lines if one["commit"] == commit}


def _show(found: Sequence[Row]) -> None:
    figures = {name: partial(Row.figure, name=name) for name in _FIGURES}
    heads = {"lines": lambda row: row.lines, "trials": lambda row: row.trials}
    heads |= {"changed": lambda row: row.changed} | figures
    words = {"without": lambda row: row.name, "verdict": lambda row: row.verdict}
    show(table("what the mechanisms are worth", found, words, heads))


def main(
    file: Annotated[Path, typer.Argument(help="YAML list of mechanisms.")],
    results: Annotated[Path, typer.Option(help="Is continued.")] = Path("ablation.jsonl"),
    seeds: Seeds = "0-2",
    only: Annotated[list[str] | None, typer.Option(help="Names that contain this.")] = None,
    task: Annotated[list[str] | None, typer.Option(help="Instead of those of the room.")] = None,
    long: Annotated[bool, typer.Option("--long", help="The long tasks, too.")] = False,
    workers: Workers = None,
    cluster: Cluster = None,
) -> None:
    """Run tasks without each mechanism, and say what got worse, and what better."""
    if subprocess.run(["git", "diff", "--quiet", "HEAD"], check=False).returncode:
        raise typer.BadParameter("commit first: the results are those of the last commit")
    commit = subprocess.check_output(["git", "rev-parse", "HEAD"], text=True).strip()
    changes = [
        one for one in mechanisms(file) if not only or any(word in one.name for word in only)
    ]
    for change in changes:
        change.of(Path(change.path).read_text(encoding="utf-8"))
    numbers, extra = list(seed_range(seeds)), LONG_TASKS if long else ()
    jobs = [
        Job(mechanism=change, task=words, seed=seed)
        for change in changes
        for words in (task or (*trials_of(change), *extra))
        for seed in (numbers[:1] if words.startswith("grasp") else numbers)
    ]
    jobs = [*{replace(job, mechanism=None): None for job in jobs}, *jobs]
    done = _read(results, commit)
    left = [job for job in jobs if job.key not in done]
    with (
        TemporaryDirectory(prefix="ablation-") as folder,
        progress("ablation", len(left)) as advance,
        results.open("a", encoding="utf-8") as out,
    ):
        work = partial(run_trial, folder=folder)
        for number, units in run_all(work, left, workers=cluster or workers, batch=_BATCH):
            trial = left[number].key
            done[trial] = units
            line = {"commit": commit, "trial": trial, "figures": units}
            print(json.dumps(line), file=out, flush=True)
            advance(False)
    wanted = {job.key for job in jobs}
    _show(list(rows(changes, {key: done[key] for key in wanted})))


if __name__ == "__main__":
    typer.run(main)
