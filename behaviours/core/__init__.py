"""What leaves build on: context, types of arguments, motion, log and memory of faults."""
