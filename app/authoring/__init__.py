"""What helps to write a task: runs without a robot, the reference of nodes."""
