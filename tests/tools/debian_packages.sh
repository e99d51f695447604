#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Make sure that a group of Debian packages is there:
# `debian_packages.sh host|cfclient|test|analysis|ompl|ci`.
# Root gets them installed; anybody else gets one line that says what is missing.
set -euo pipefail

is_there() { # by what it provides: it may well come from elsewhere than a Debian package
  case $1 in
    python3) python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' ;;
    python3-venv) python3 -c 'import ensurepip, venv' ;;
    python3-dev) python3 -c 'import sysconfig, pathlib, sys
sys.exit(not pathlib.Path(sysconfig.get_path("include"), "Python.h").exists())' ;;
    gcc | g++ | chromium) command -v "$1" ;;
    libc6-dev) echo '#include <stdlib.h>' | gcc -fsyntax-only -xc - ;;
    gcc-arm-none-eabi) command -v arm-none-eabi-gcc ;;
    *) dpkg-query --show --showformat '${Status}\n' "$1" | grep -q '^install ok installed' ;;
  esac >/dev/null 2>&1
}

case ${1:-} in
  host) packages=(python3 python3-venv python3-dev gcc libc6-dev) ;;
  cfclient) packages=(python3 python3-venv libegl1 libgl1 libxkbcommon0 libxkbcommon-x11-0
    libdbus-1-3 libfontconfig1 libglib2.0-0 libusb-1.0-0 fonts-dejavu-core) ;;
  test) packages=(chromium fonts-dejavu-core gcc-arm-none-eabi libnewlib-arm-none-eabi) ;;
  analysis) packages=(clang libclang-rt-14-dev clang-tidy cppcheck frama-c-base) ;;
  ompl) packages=(g++ libompl-dev) ;;
  ci) packages=(python3 python3-venv python3-dev gcc libc6-dev make gcc-arm-none-eabi
    libnewlib-arm-none-eabi chromium fonts-dejavu-core
    clang libclang-rt-14-dev clang-tidy cppcheck frama-c-base) ;;
  *) echo "usage: $0 host|cfclient|test|analysis|ompl|ci" >&2 && exit 2 ;;
esac

missing=()
for package in "${packages[@]}"; do
  is_there "$package" || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0

if [ "$(id -u)" -eq 0 ] && command -v apt-get >/dev/null; then
  apt-get -o Acquire::Retries=5 -qq update
  DEBIAN_FRONTEND=noninteractive apt-get -o Acquire::Retries=5 -qq install \
    --yes --no-install-recommends "${missing[@]}" >/dev/null
else
  echo "missing: ${missing[*]} (Debian: sudo apt install ${missing[*]})" >&2
  exit 1
fi
