#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Pack the sources, build the wheel from that archive, install it into an empty environment, fly the
# demo from an empty folder.
set -euo pipefail

checkout=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python=$folder/venv/bin/python
install=("$python" -m pip install --quiet --disable-pip-version-check --retries 10 --no-compile)

python3 -m venv "$folder/venv"
"${install[@]}" build
"$python" -m build --outdir "$folder" "$checkout" >"$folder/log" || { cat "$folder/log"; exit 1; }
"${install[@]}" "$folder"/wayflie-*.whl

mkdir "$folder/empty"
cd "$folder/empty"
"$folder/venv/bin/wayflie" --version
"$folder/venv/bin/wayflie" demo --headless --record off
