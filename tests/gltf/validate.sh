#!/usr/bin/env bash
# usage: validate.sh FILE.glb : Khronos' glTF validator must find no error and no warning. Needs npm.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
file=$(realpath "$1")
tool=$(mktemp -d)
trap 'rm -rf "$tool"' EXIT
cp "$here/validate.cjs" "$tool"
cd "$tool"
npm install --silent --no-fund --no-audit gltf-validator@2.0.0-dev.3.10
node validate.cjs "$file"
