"""Groot2 endpoint: the monitor protocol of BehaviorTree.CPP 4; needs the extra `groot`."""

from app.live.groot.server import USUAL_PORT, GrootError, GrootServer
