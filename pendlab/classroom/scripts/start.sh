#!/bin/sh
# Opens the series in JupyterLab.
cd "$(dirname "$0")"
exec .venv/bin/jupyter lab notebooks/00_start_here.ipynb "$@"
