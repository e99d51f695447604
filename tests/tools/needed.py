# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools that not every machine has; without them a test says what it could not check."""

import os
import shutil

import pytest


def need(program: str, package: str, for_what: str) -> None:
    """Skip without this program; on a CI machine its absence is a failure."""
    if shutil.which(program) is not None:
        return
    message = f"NOT CHECKED: {for_what} ({program} is missing: apt install {package})"
    if os.environ.get("CI") == "true":
        pytest.fail(message)
    pytest.skip(message)
