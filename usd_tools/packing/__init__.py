"""The parts of `pack` and `unpack`."""
