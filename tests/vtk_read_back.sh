#!/bin/sh
# Reads the VTK files with VTK itself: `tests/vtk_read_back.sh [RESULT ...]`.
# A sample with known numbers always; folders of runs with .pvd files if named.
# VTK comes from PyPI, once, into target/vtk-venv. Non-zero exit on a mismatch.
set -eu
caller=$PWD
top=$(cd "$(dirname "$0")/.." && pwd)
venv=$top/target/vtk-venv
sample=$top/target/vtk-sample

if ! "$venv/bin/python" -c 'import numpy, vtkmodules.vtkIOXML' 2>/dev/null; then
    echo "installing VTK for Python into $venv"
    python3 -m venv --clear "$venv"
    # VTK asks for matplotlib too, which reading does not need.
    "$venv/bin/pip" install --quiet --disable-pip-version-check numpy==2.4.6
    "$venv/bin/pip" install --quiet --disable-pip-version-check --no-deps vtk==9.5.2
fi
(cd "$top" && cargo run --quiet --package dempfv --example vtk_sample -- "$sample")
cd "$caller"
exec "$venv/bin/python" "$top/tests/vtk_read_back.py" "$sample" "$@"
