"""Bridges to BehaviorTree.CPP 4: tasks as its XML, and the logs that Groot2 replays."""

from trees.btcpp.btlog import STATUS_CODES, BtLog, tree_xml
from trees.btcpp.export import export_files, export_xml
