"""Bridges to BehaviorTree.CPP 4: its XML, both ways, and the logs that Groot2 replays."""

from trees.btcpp.btlog import BtLog
from trees.btcpp.export import export_xml
from trees.btcpp.importing import import_xml

__all__ = ["BtLog", "export_xml", "import_xml"]
