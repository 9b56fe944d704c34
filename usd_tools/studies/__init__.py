"""The parts of `study`: a blind page with pairs of motions, and what its answers say."""
