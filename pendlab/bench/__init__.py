"""The rig in software: imperfections, kernel, equations generated from the derivation, simulation."""
