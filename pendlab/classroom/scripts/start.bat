@echo off
cd /d "%~dp0"
.venv\Scripts\jupyter lab notebooks\00_start_here.ipynb
