"""The Rerun viewer as a process: beside a run, for a recording, or without a window."""
