"""The live endpoint for Groot2: a run speaks the monitor protocol of BehaviorTree.CPP 4.

`protocol` has the bytes, `document` the tree as Groot2 reads it, `breakpoints` what its hooks do,
`server` the sockets. Needs the extra `groot`.
"""

from app.live.groot.server import USUAL_PORT, GrootError, GrootServer

__all__ = ["USUAL_PORT", "GrootError", "GrootServer"]
