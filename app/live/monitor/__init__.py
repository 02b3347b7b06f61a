"""Recording of a run, and the Rerun viewer.

`Recorder` takes one `Snapshot` a tick, writes the recording and serves it; `Viewer` starts the
viewer that connects to it. Rerun is imported when the first recorder is made.
"""

from app.choices import View
from app.live.monitor.headless import HeadlessViewer, headless_viewer
from app.live.monitor.open_recording import open_in_viewer
from app.live.monitor.recorder import Recorder, RecorderError
from app.live.monitor.viewer import Viewer, ViewError, ViewOptions
from app.live.web.ports import Address

__all__ = [
    "Address",
    "HeadlessViewer",
    "Recorder",
    "RecorderError",
    "View",
    "ViewError",
    "ViewOptions",
    "Viewer",
    "headless_viewer",
    "open_in_viewer",
]
