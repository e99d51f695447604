#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Make sure that groups of Debian packages are there:
# `debian_packages.sh host|test|chip|web|analysis|cfclient|ompl...`.
# Root gets them installed; anybody else gets one line that says what is missing.
set -euo pipefail

is_there() { # by what it provides: it may well come from elsewhere than a Debian package
  case $1 in
    python3) command -v python3 ;;
    python3-venv) python3 -c 'import ensurepip, venv' ;;
    python3-dev) python3 -c 'import sysconfig, pathlib, sys
sys.exit(not pathlib.Path(sysconfig.get_path("include"), "Python.h").exists())' ;;
    libc6-dev) echo '#include <stdlib.h>' | gcc -fsyntax-only -xc - ;;
    libclang-rt-dev) echo 'int LLVMFuzzerTestOneInput(void) { return 0; }' |
      clang -fsanitize=fuzzer -xc - -o /dev/null ;;
    gcc-arm-none-eabi) command -v arm-none-eabi-gcc ;;
    frama-c-base) command -v frama-c ;;
    gcc | g++ | git | chromium | clang | clang-tidy | cppcheck) command -v "$1" ;;
    *) dpkg-query --show --showformat '${Status}\n' "$1" | grep -q '^install ok installed' ;;
  esac >/dev/null 2>&1
}

missing=()
for group in "$@"; do
  case $group in
    host) packages=(python3 python3-venv python3-dev gcc libc6-dev) ;;
    test) packages=(git) ;;
    chip) packages=(gcc-arm-none-eabi libnewlib-arm-none-eabi) ;;
    web) packages=(chromium fonts-dejavu-core) ;;
    analysis) packages=(clang libclang-rt-dev clang-tidy cppcheck frama-c-base) ;;
    cfclient) packages=(libegl1 libgl1 libxkbcommon0 libxkbcommon-x11-0 libdbus-1-3
      libfontconfig1 libglib2.0-0 libusb-1.0-0 fonts-dejavu-core) ;;
    ompl) packages=(g++ libompl-dev) ;;
    *) echo "$0: no group $group" >&2 && exit 2 ;;
  esac
  for package in "${packages[@]}"; do
    is_there "$package" || missing+=("$package")
  done
done

if [ ${#missing[@]} -gt 0 ]; then
  if [ "$(id -u)" -ne 0 ] || ! command -v apt-get >/dev/null; then
    echo "missing: ${missing[*]} (Debian: sudo apt install ${missing[*]})" >&2
    exit 1
  fi
  get=(apt-get -qq -o Acquire::Retries=5 -o DPkg::Lock::Timeout=300)
  "${get[@]}" update
  DEBIAN_FRONTEND=noninteractive "${get[@]}" install --yes --no-install-recommends \
    "${missing[@]}" >/dev/null
fi
python3 -c 'import sys
sys.exit(sys.version_info < (3, 11) and f"python3 is {sys.version.split()[0]}: 3.11 is needed")'
