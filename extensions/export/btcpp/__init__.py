"""Tasks as XML for BehaviorTree.CPP 4."""

from extensions.export.btcpp.export import export_files, export_xml
