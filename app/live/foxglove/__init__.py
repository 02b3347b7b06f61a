"""Runs as ROS 2 messages, into MCAP files and live; needs the extra `foxglove`."""

from config import UserError

try:
    from app.live.foxglove.sinks import FoxgloveServer, write_mcap
except ModuleNotFoundError as error:
    raise UserError(
        f'MCAP and Foxglove need {error.name}: pip install "frankie-task[foxglove]"'
    ) from None
