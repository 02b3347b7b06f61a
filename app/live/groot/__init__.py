"""The live endpoint for Groot2: a run speaks the monitor protocol of BehaviorTree.CPP 4.

`protocol` encodes messages, `tree_xml` the tree; `client_hooks` keeps the hooks that Groot2
inserts; `server` has the sockets. Needs the extra `groot`.
"""

from app.live.groot.server import USUAL_PORT, GrootError, GrootServer

__all__ = ["USUAL_PORT", "GrootError", "GrootServer"]
