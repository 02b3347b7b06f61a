"""Explanation of a run as one HTML file to read, send and print: first cause, map, and the rest."""

from __future__ import annotations

import json
from html import escape

from app.core import OPTIONS, recorded_scene
from app.live import STYLE, Plan, line
from app.review.explanation import Explanation
from app.review.finished import read_motion
from config import UserError
from controller import Pose2D, se3_of
from robots import load_robot

_STYLE = """:root { color-scheme: only light; }
body { max-width: 60rem; margin: 1.5rem auto; padding: 0 1rem; color: #1a1d22;
  font: 15px/1.45 system-ui, sans-serif; }
h1 { font-size: 1.2rem; } h2 { font-size: 1rem; margin: 1.2rem 0 .3rem; break-after: avoid; }
.cause { font-size: 1.3rem; font-weight: 700; border-left: 6px solid #b3261e; padding-left: .8rem }
.success .cause { border-color: #17692f; }
pre { font: 12.5px/1.45 ui-monospace, monospace; white-space: pre-wrap; margin: 0; }
figure { margin: 1rem 0; break-inside: avoid; } .plan { max-height: 26rem; }"""


def explanation_page(run: Explanation) -> str:
    """The page; it needs no other file and runs no script."""
    head, why, *sections = run.sections
    parts = [
        f"<h1>{escape(head[0])}</h1>",
        f'<p class="cause">{escape(why[0])}</p>',
        _preformatted(why[1:]),
        _map(run),
    ]
    for first, *rest in sections:
        parts.append(f"<h2>{escape(first)}</h2>{_preformatted(rest)}")
    return (
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f"<title>{escape(head[0])}</title><style>{STYLE.read_text(encoding='utf-8')}{_STYLE}</style></head>"
        f'<body class="{escape(run.outcome)}">{"".join(parts)}</body></html>\n'
    )


def _preformatted(lines: list[str]) -> str:
    return f"<pre>{escape(chr(10).join(lines))}</pre>" if lines else ""


def _map(run: Explanation) -> str:
    """The furniture, the way of the base, and where it ended; empty if they are not known."""
    folder = run.record.folder
    try:
        options = json.loads((folder / OPTIONS).read_text(encoding="utf-8"))
        robot = load_robot(options["robot"])
        plan = Plan(recorded_scene(options, robot), robot.base.size)
        way = read_motion(folder)[0][:, 1:4]
    except (OSError, UserError, LookupError, TypeError, ValueError):
        return ""
    drawn = plan.fixed + line("track", way[::20, :2]) + plan.robot(se3_of(Pose2D(*way[-1])))
    return (
        f'<figure><svg class="plan" viewBox="{plan.view_box(way[:, :2])}">{drawn}</svg>'
        "<figcaption>The way of the base, by odometry, and where it ended.</figcaption></figure>"
    )
