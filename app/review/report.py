"""Explanation of a run as one self-contained web page: `explain --html FILE`."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterator, Sequence
from html import escape
from pathlib import Path

import numpy as np

from app.core import RECORDING, STATES
from app.review.event_log import Log, read_log
from app.review.explanation import Explanation, cause_text, explain
from app.review.recorded_images import NoDepthError, depth_pictures
from app.review.timeline import Timeline, timeline
from app.task_time import task_time
from app.terminal import visible
from config import UserError

_MOST_PICTURES = 6
_BEFORE = 0.3
"""Pictures are taken this long before something failed [s]."""
_PLAN = 360.0
"""Width of the plan [px]."""
_GLYPH = {"RUNNING": "▶", "SUCCESS": "✔", "FAILURE": "✗", "INVALID": "■", "": "·"}
_STYLE = """
:root { color-scheme: dark; }
body { background: #14171c; color: #dfe3e8; font: 15px/1.5 system-ui, sans-serif;
       max-width: 1080px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.4rem; } h2 { font-size: 1.05rem; margin-top: 2rem; color: #9fb3c8; }
.cause { border-left: 4px solid #e0574c; background: #1d2128; padding: .7rem 1rem; }
.cause.good { border-color: #3fa45b; }
table { border-collapse: collapse; } td, th { text-align: left; padding: .2rem .9rem .2rem 0; }
td.n { text-align: right; font-variant-numeric: tabular-nums; }
.strip { display: flex; flex-wrap: wrap; gap: .6rem; } figure { margin: 0; }
figure img { border-radius: 4px; display: block; } figcaption { color: #9fb3c8; font-size: .8rem; }
pre { background: #1d2128; padding: .8rem; overflow-x: auto; font-size: .8rem; }
.tree div { white-space: pre; font-family: ui-monospace, monospace; font-size: .85rem; }
.SUCCESS { color: #6fcf8a; } .FAILURE { color: #ff8078; } .RUNNING { color: #6db3ff; }
.INVALID, .none { color: #7d8794; } .here { font-weight: bold; background: #3a2224; }
"""


class ReportError(UserError):
    """The page cannot be written."""


def write_report(folder: Path, out: Path) -> None:
    """Write the page about a run to a file.

    Raises:
        DamagedRunError: the run cannot be explained.
        ReportError: the file cannot be written.
    """
    run, log = explain(folder), read_log(folder)
    text = "\n".join(_page(run, log, folder))
    try:
        out.write_text(text + "\n", encoding="utf-8")
    except OSError as error:
        raise ReportError(f"{out}: cannot be written ({error.strerror})") from error


def _page(run: Explanation, log: Log, folder: Path) -> Iterator[str]:
    title = _safe(f"{run.record.task}: {run.outcome} after {task_time(run.time, run.paused_s)}")
    yield "<!doctype html>"
    yield f'<html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
    yield f"<style>{_STYLE}</style></head><body>"
    yield f"<h1>{title}</h1>"
    good = run.outcome == "success"
    lead = cause_text(run) or str(run).split("\n\n")[1]
    yield f'<p class="cause{" good" if good else ""}">{_safe(lead)}</p>'
    yield from _pictures(run, log, folder)
    if run.attempts:
        yield "<h2>Attempts</h2>"
        rows = [
            (str(one.number), f"{one.begin:.1f} s", f"{one.end - one.begin:.1f} s", one.result)
            for one in run.attempts
        ]
        yield from _table(("", "from", "took", "what came of it"), rows)
    if run.leaf_times:
        yield "<h2>What took the time</h2>"
        times = [(one.name, f"{one.seconds:.1f} s", str(one.rounds)) for one in run.leaf_times]
        yield from _table(("", "in all", "rounds"), times)
    yield "<h2>The tree at the end</h2>"
    yield from _tree(run, log, timeline(log))
    yield "<h2>In full</h2>"
    yield f"<pre>{_safe(str(run))}</pre>"
    yield "</body></html>"


def _pictures(run: Explanation, log: Log, folder: Path) -> Iterator[str]:
    """Depth images at failures and at the end, and the path of the base."""
    failed = [one.cause.time for one in run.attempts if one.cause is not None]
    causes = [run.cause.time] if run.cause is not None else []
    wrong = sorted({round(time, 2) for time in (*causes, *failed)})
    times = sorted({*wrong, round(run.time, 2)})
    if len(times) > _MOST_PICTURES:
        times = [*times[: _MOST_PICTURES // 2], *times[-(_MOST_PICTURES // 2) :]]
    try:
        before = [log.session_time(max(0.0, time - _BEFORE)) for time in times]
        shown = depth_pictures(folder / RECORDING, before)
    except NoDepthError:
        shown = []
    plan = _plan(folder, [log.session_time(time) for time in wrong])
    if not (shown or plan):
        return
    yield "<h2>What it saw, and where it went</h2>"
    yield '<div class="strip">'
    for time, png in shown:
        image = f"data:image/png;base64,{b64encode(png).decode('ascii')}"
        caption = f"depth at {log.task_time(time):.1f} s"
        yield f'<figure><img alt="{caption}" src="{image}">'
        yield f"<figcaption>{caption}</figcaption></figure>"
    yield from plan
    yield "</div>"


def _plan(folder: Path, times: Sequence[float]) -> list[str]:
    """Path of the base from above, as SVG, with marks where something failed."""
    try:
        states = np.load(folder / STATES, allow_pickle=False)
        stamps, x, y = states[:, 0], states[:, 1], states[:, 2]
    except (OSError, ValueError, EOFError, IndexError, MemoryError):
        return []
    if len(stamps) < 2 or not np.isfinite(states[:, :3]).all():
        return []
    low = np.array([x.min(), y.min()]) - 0.4
    size = np.array([x.max(), y.max()]) + 0.4 - low
    scale = _PLAN / float(size.max())
    width, height = scale * size
    across, up = scale * (x - low[0]), height - scale * (y - low[1])
    every = max(1, len(x) // 400)
    way = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across[::every], up[::every], strict=True))
    marks = [
        f'<circle cx="{np.interp(t, stamps, across):.1f}" cy="{np.interp(t, stamps, up):.1f}" '
        'r="5" fill="none" stroke="#ff8078" stroke-width="2"/>'
        for t in times
    ]
    legend = "; circles: something failed" if marks else ""
    return [
        f'<figure><svg width="{width:.0f}" height="{height:.0f}" style="background:#1d2128">',
        f'<polyline points="{way}" fill="none" stroke="#6db3ff" stroke-width="2"/>',
        *marks,
        f"</svg><figcaption>the base from above, {size[0]:.1f} x {size[1]:.1f} m{legend}"
        "</figcaption></figure>",
    ]


def _tree(run: Explanation, log: Log, spans: Timeline) -> Iterator[str]:
    yield '<div class="tree">'
    for index, node in enumerate(log.nodes):
        rounds = spans.rounds.get(index, ())
        status, message = (rounds[-1].status, rounds[-1].message) if rounds else ("", "")
        here = " here" if run.cause is not None and index == run.cause.node else ""
        indent = "  " * node.path.count("/")
        line = f"{indent}{_GLYPH[status]} {node.title}"
        if len(rounds) > 1:
            line += f"  x{len(rounds)}"
        if message and spans.is_leaf(index):
            line += f"  {message}"
        yield f'<div class="{status or "none"}{here}">{_safe(line)}</div>'
    yield "</div>"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> Iterator[str]:
    yield "<table><tr>" + "".join(f"<th>{_safe(cell)}</th>" for cell in head) + "</tr>"
    for row in rows:
        yield "<tr>" + "".join(f"<td>{_safe(cell)}</td>" for cell in row) + "</tr>"
    yield "</table>"


def _safe(text: str) -> str:
    """Escaped text without invisible characters."""
    return escape(visible(text))
