#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Build the wheel, install it into an empty environment, fly the demo from an empty folder.
set -euo pipefail

checkout=$(cd "$(dirname "$0")/../.." && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
quiet=(--quiet --disable-pip-version-check --retries 10)

python3 -m venv "$folder/venv"
rm -rf "$checkout/build/lib"* "$checkout/build/bdist"* # else files that are gone are packed as well
"$folder/venv/bin/pip" wheel "${quiet[@]}" --no-deps --wheel-dir "$folder" "$checkout"
"$folder/venv/bin/pip" install "${quiet[@]}" "$folder"/wayflie-*.whl

mkdir "$folder/empty"
cd "$folder/empty"
"$folder/venv/bin/wayflie" --version
"$folder/venv/bin/wayflie" demo --headless --record off
