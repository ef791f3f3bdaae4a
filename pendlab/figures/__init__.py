"""The figures of the paper, drawn from a rig and a design."""
