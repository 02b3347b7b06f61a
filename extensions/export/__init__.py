"""Export: tasks for BehaviorTree.CPP 4 and Groot2, and runs as LeRobot datasets."""
