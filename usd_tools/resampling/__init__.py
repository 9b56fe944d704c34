"""The parts of `resample`."""
