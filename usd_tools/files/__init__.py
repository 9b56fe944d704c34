"""Files on disk: checks, atomic writes, stages, packages."""
