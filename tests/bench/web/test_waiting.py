# SPDX-License-Identifier: GPL-3.0-or-later
"""How the page bench evaluates a recording and what the page noted."""

import pytest

from ground.core import CellState
from ground.model import MapPiece
from tests.bench.web.command import waiting
from tests.ground.stations import packet_of

FREE = bytes([CellState.FREE] * 64)


def test_a_change_waits_for_the_first_frame_that_knows_of_it() -> None:
    pieces = [packet_of(MapPiece(tile, 0, FREE, ())) for tile in (0, 1, 1, 2, 3)]
    heard = list(zip((10.0, 10.1, 10.2, 10.3, 10.4), pieces, strict=True))
    shown = [(1, 10_050.0), (3, 10_500.0)]
    figures = waiting(heard, shown)
    assert figures["map_changes"] == 2, "not what was before the first frame or after the last"
    assert figures["map_wait_median_s"] == pytest.approx((0.4 + 0.2) / 2)
