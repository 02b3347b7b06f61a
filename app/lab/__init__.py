"""The laboratory: benches, and the training and evaluation of grasp networks."""
