"""Explanation of a run as one HTML file to read, send and print: first cause, map, and the rest."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

from app.core import OPTIONS, PLACES, RECORDING, TASK, recorded_robot, recorded_scene
from app.review import Explanation, NoDepthError, depth_images, read_motion, recorded_time
from behaviours import Region
from config import UserError
from config.planar import Pose2D
from controller import se3_of
from extensions.page.plan import STYLE, Plan, line
from extensions.page.small_picture import depth_picture
from robots import load_robot
from trees.language import load

_STYLE = """:root { color-scheme: only light; }
body { max-width: 60rem; margin: 1.5rem auto; padding: 0 1rem; color: #1a1d22;
  font: 15px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.2rem; } h2 { font-size: 1rem; margin: 1.2rem 0 .3rem; break-after: avoid; }
.cause { font-size: 1.3rem; font-weight: 700; border-left: 6px solid #b3261e; padding-left: .8rem }
.success .cause { border-color: #17692f; }
pre { font: 12.5px/1.45 ui-monospace, monospace; white-space: pre-wrap; margin: 0;
  overflow-wrap: anywhere; }
pre div { padding-left: calc(1ch * var(--hang)); text-indent: calc(-1ch * var(--hang)); }
figure { margin: 1rem 0; break-inside: avoid; } .plan { max-height: 26rem; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, 12rem); gap: 1rem; }
.pictures figure { margin: 0; font-size: .85rem; } img { width: 100%; }
@page { margin: 15mm; } @media print { body { margin: 0; padding: 0; } }"""
_MOST_PICTURES = 8


def explanation_page(run: Explanation) -> str:
    """The page; it needs no other file and runs no script."""
    head, why, *sections = run.sections
    parts = [
        f"<h1>{escape(head[0])}</h1>",
        f'<p class="cause">{escape(why[0])}</p>',
        _preformatted(why[1:]),
        _map(run),
        _pictures(run),
    ]
    for first, *rest in sections:
        kind = "h2" if rest else "p"
        parts.append(f"<{kind}>{escape(first)}</{kind}>{_preformatted(rest)}")
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(head[0])}</title><style>{STYLE.read_text(encoding='utf-8')}{_STYLE}</style></head>"
        f'<body class="{escape(run.outcome)}"><main>{"".join(parts)}</main></body></html>\n'
    )


def _preformatted(lines: list[str]) -> str:
    """Lines whose last column hangs where it begins."""
    rows = (f'<div style="--hang:{one.rfind("  ") + 2}">{escape(one)}</div>' for one in lines)
    return f"<pre>{''.join(rows)}</pre>" if lines else ""


def drawn_plan(folder: Path) -> tuple[str, str, str] | None:
    """Furniture and regions as SVG; the way of the base and where it ended; and the view box.

    None if the scene or the motion of the run is not known.
    """
    try:
        options = json.loads((folder / OPTIONS).read_text(encoding="utf-8"))
        robot = load_robot(recorded_robot(folder, options))
        scene = replace(recorded_scene(options, robot), regions=_regions(folder, options))
        plan = Plan(scene, robot.base.size)
        way = read_motion(folder)[0][:, 1:4]
        moved = line("track", way[::20, :2]) + plan.robot(se3_of(Pose2D(*way[-1])))
    except (OSError, UserError, LookupError, TypeError, ValueError):
        return None
    return plan.fixed, moved, plan.view_box(way[:, :2])


def _map(run: Explanation) -> str:
    """The plan; empty if it is not known."""
    if (plan := drawn_plan(run.record.folder)) is None:
        return ""
    fixed, moved, box = plan
    return (
        f'<figure><svg class="plan" viewBox="{box}">{fixed}{moved}</svg>'
        "<figcaption>Regions of the task (green); the way of the base, by odometry, and where it "
        "ended.</figcaption></figure>"
    )


def _regions(folder: Path, options: Mapping[str, Any]) -> tuple[Region, ...]:
    """The regions of the task of a run."""
    places = folder / PLACES
    task = load(
        folder / TASK,
        overrides=options["parameters"],
        places=places if places.is_file() else None,
    )
    return tuple(one for one in task.regions.values() if isinstance(one, Region))


def _pictures(run: Explanation) -> str:
    """The last image of the camera in each failed attempt; empty if there is none."""
    folder = run.record.folder
    failed = [one for one in run.attempts if one.cause is not None][:_MOST_PICTURES]
    spans = [[recorded_time(folder, time) for time in (one.begin, one.end)] for one in failed]
    last: dict[int, Any] = {}
    try:
        for time, depth in depth_images(folder / RECORDING) if failed else ():
            for index, (begin, end) in enumerate(spans):
                if begin <= time <= end:
                    last[index] = depth
    except NoDepthError:
        return ""
    shown = "".join(
        f'<figure><img alt="" src="{depth_picture(last[index])}"><figcaption>{one.begin:.1f} s to '
        f"{one.end:.1f} s, {escape(one.what)}: {escape(one.result)}</figcaption></figure>"
        for index, one in enumerate(failed)
        if index in last
    )
    head = "<h2>What the camera saw last in failed attempts</h2>"
    return f'{head}<div class="pictures">{shown}</div>' if shown else ""
