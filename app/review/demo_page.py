"""Static web page that shows a recording in any browser, without contacting another host."""

from __future__ import annotations

import html
import shutil
from pathlib import Path

from app.core import RECORDING
from app.live import WebFilesError, viewer_page, viewer_web_files
from app.review.explanation import explain
from app.review.finished import read_run
from app.task_time import task_time
from config import UserError

_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self'; frame-src 'self'; "
    "base-uri 'none'; form-action 'none'"
)
_PAGE = """<!doctype html>
<html lang="en">
<head>
  <meta charset="utf-8">
  <meta http-equiv="Content-Security-Policy" content="{policy}">
  <meta name="viewport" content="width=device-width, initial-scale=1">
  <title>{title}</title>
  <link rel="icon" href="viewer/favicon.ico">
  <link rel="stylesheet" href="page.css">
  <script src="page.js" defer></script>
</head>
<body>
  <header><h1>{title}</h1><p>{outcome}</p></header>
  <p id="local" hidden>A browser opens no recording from a file: start
  <code>python3 -m http.server</code> in this folder and open <code>http://localhost:8000/</code>.</p>
  <iframe title="the recording"></iframe>
  <details><summary>What happened</summary><pre>{text}</pre></details>
</body>
</html>
"""
_SCRIPT = """"use strict";
// The viewer needs the recording's whole address, which is that of this page.
if (location.protocol === "file:") {
  document.getElementById("local").hidden = false;
} else {
  const recording = encodeURIComponent(new URL("recording.rrd", location.href).href);
  const options = "&theme=dark&hide_welcome_screen=1&persist=0";
  document.querySelector("iframe").src = `viewer/index.html?url=${recording}${options}`;
}
"""
_STYLE = """body { margin: 0; height: 100vh; display: flex; flex-direction: column;
  color-scheme: dark; background: #14171c; color: #d9dde3; font: 14px/1.4 system-ui, sans-serif; }
header { display: flex; gap: 16px; align-items: baseline; padding: 8px 16px; }
h1 { font-size: 17px; margin: 0; } p { margin: 0; color: #9aa3af; }
#local { padding: 24px; } iframe { flex: 1; border: 0; min-height: 0; }
details { padding: 6px 16px; max-height: 40vh; overflow: auto; } summary { cursor: pointer; }
pre { font: 13px/1.45 ui-monospace, monospace; white-space: pre-wrap; }
"""


class DemoPageError(UserError):
    """The page cannot be made."""


def demo_page(run: Path, folder: Path) -> Path:
    """Make the page of a run in a folder, made if missing; returns its first file.

    Raises:
        DemoPageError: the run has no recording, or the folder cannot be written.
        WebFilesError: there is no web viewer.
    """
    recording = run / RECORDING
    if not recording.is_file():
        raise DemoPageError(f"{recording}: the run has no recording; name another")
    if folder.exists() and not (folder / "viewer").is_dir() and any(folder.iterdir()):
        raise DemoPageError(f"{folder}: has other files in it; name an empty folder")
    record = read_run(run)
    try:
        (folder / "viewer").mkdir(parents=True, exist_ok=True)
        for file in sorted(viewer_web_files().iterdir()):
            shutil.copyfile(file, folder / "viewer" / file.name)
        (folder / "viewer" / "index.html").write_bytes(viewer_page())
        shutil.copyfile(recording, folder / RECORDING)
        text = {
            "policy": _POLICY,
            "title": html.escape(record.task),
            "outcome": html.escape(_outcome(run)),
            "text": html.escape(_explained(run)),
        }
        (folder / "index.html").write_text(_PAGE.format(**text), encoding="utf-8")
        (folder / "page.js").write_text(_SCRIPT, encoding="utf-8")
        (folder / "page.css").write_text(_STYLE, encoding="utf-8")
    except WebFilesError:
        raise
    except OSError as error:
        raise DemoPageError(f"{folder}: cannot be written ({error.strerror})") from error
    return folder / "index.html"


def _outcome(run: Path) -> str:
    summary = read_run(run).summary
    tried = summary.placed or summary.attempts
    duration, paused = summary.duration_s, summary.paused_s
    time = "" if duration is None else f" after {task_time(duration, paused)}"
    placed = f", {summary.placed} of {summary.objects} objects placed" if tried else ""
    return f"{summary.outcome}{time}{placed}"


def _explained(run: Path) -> str:
    try:
        return str(explain(run))
    except UserError as error:
        return str(error)
