"""Check, open and write files: paths, atomic writes, stages, packages."""
