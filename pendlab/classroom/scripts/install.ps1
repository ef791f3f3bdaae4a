# Installs the series from this folder alone; no network is used.
$ErrorActionPreference = 'Stop'
Set-Location $PSScriptRoot
py -@VERSION@ -m venv .venv
if ($LASTEXITCODE) { throw 'Python @VERSION@ is needed: see README-BUNDLE.md' }
$env:PIP_CONFIG_FILE = 'NUL'
.venv\Scripts\python -m pip install --no-index --find-links wheels --disable-pip-version-check -q -r environment.txt
if ($LASTEXITCODE) { throw 'The installation failed.' }
Write-Output 'Installed. Start with: .\start.bat'
