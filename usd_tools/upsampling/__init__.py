"""The parts of `upsample`."""
