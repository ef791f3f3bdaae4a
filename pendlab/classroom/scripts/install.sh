#!/bin/sh
# Installs the series from this folder alone; no network is used.
set -eu
cd "$(dirname "$0")"
python="${PYTHON:-python@VERSION@}"
"$python" -m venv .venv
PIP_CONFIG_FILE=/dev/null .venv/bin/python -m pip install --no-index --find-links wheels \
    --disable-pip-version-check -q -r environment.txt
echo "Installed. Start with: ./start.sh"
