"""Controls and panels round tested figures, for the notebooks."""
