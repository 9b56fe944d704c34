"""Find, read, resample and write skeletal animation in USD."""
