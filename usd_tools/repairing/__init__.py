"""The parts of `repair`."""
