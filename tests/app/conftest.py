# SPDX-License-Identifier: GPL-3.0-or-later
import pytest

from tests.app.drone import Drone


@pytest.fixture
def drone() -> Drone:
    """A drone on the floor in the middle of the room, ready to fly."""
    return Drone().boot()
