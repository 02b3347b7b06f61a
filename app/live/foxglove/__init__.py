"""Runs as ROS 2 messages, into MCAP files and live; needs the extra `foxglove`."""

from app.live.foxglove.sinks import FoxgloveError, write_mcap
