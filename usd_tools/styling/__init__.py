"""The parts of `metric`: style as data, stored with an animation whose samples stay as they are."""
