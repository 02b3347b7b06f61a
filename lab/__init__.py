"""The laboratory: benches, training, evaluation and calibration; the product never imports it."""
