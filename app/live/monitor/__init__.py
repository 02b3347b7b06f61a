"""Recording of a run for the Rerun viewer.

`Recorder` takes one `Snapshot` a tick, writes the recording and serves it to viewers. Rerun is
imported when the first recorder is made.
"""

from app.live.monitor.recorder import Recorder, RecorderError, draw_robot
