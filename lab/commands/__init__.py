"""The commands of the laboratory: `frankie-task bench`, `grasp` and `calibrate`."""
