# SPDX-License-Identifier: GPL-3.0-or-later
"""All tests here compile for the chip."""

import pytest

from tests.tools.needed import need


@pytest.fixture(autouse=True, scope="session")
def compiler() -> None:
    need("arm-none-eabi-gcc", "gcc-arm-none-eabi libnewlib-arm-none-eabi", "the chip in the loop")
