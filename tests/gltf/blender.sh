#!/usr/bin/env bash
# usage: blender.sh RUN_FOLDER : Blender loads export/scene.glb with the materials of materials.npy. Needs Python 3.11,
# for which PyPI has Blender as a module.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
venv=$(mktemp -d)
trap 'rm -rf "$venv"' EXIT
python3.11 -m venv "$venv"
"$venv/bin/pip" install --quiet bpy==5.0.1
"$venv/bin/python" "$here/blender.py" "$1"
