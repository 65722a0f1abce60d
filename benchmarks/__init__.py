"""Measurements of speed, memory and size. A package, since others install a folder of this name, too."""
