"""Bridges to BehaviorTree.CPP 4: tasks as its XML, and the logs that Groot2 replays."""

from trees.btcpp.btlog import BtLog
from trees.btcpp.export import export_files, export_xml
from trees.btcpp.ports import TAGS

__all__ = ["TAGS", "BtLog", "export_files", "export_xml"]
