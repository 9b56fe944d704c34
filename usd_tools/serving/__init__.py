"""Serve other programs that cannot have NumPy's and Numba's libraries inside: one process, over a pipe."""
