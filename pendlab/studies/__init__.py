"""Studies built on the core: controllability, uncertainty, transmission, pushes, timing, C code."""
