"""The parts of `downsample`."""
