# SPDX-License-Identifier: GPL-3.0-or-later
"""The map that Foxglove shows: once a second, and at the end as it is then."""

from pathlib import Path
from typing import Any

from ground.core import CellState
from ground.model import MapPiece
from ground.record.foxview import MAP_EVERY_NS, FoxgloveView
from ground.record.writer import RecordFile
from tests.ground.fakelink import HELLO
from tests.ground.stations import packet_of

TILE_CELLS = 64
FREE = 255


class Shown(RecordFile):
    """Remembers how many free cells each grid has."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, {})
        self.free: list[int] = []

    def show(self, topic: str, message: Any, now_ns: int) -> None:  # noqa: ANN401
        super().show(topic, message, now_ns)
        if topic == "/view/grid":
            self.free.append(message.data.count(FREE))


def test_the_last_view_of_the_map_is_the_whole_map(tmp_path: Path) -> None:
    file = Shown(tmp_path / "flight.mcap")
    view = FoxgloveView(file)
    begin_ns = MAP_EVERY_NS
    view.take(HELLO, begin_ns)
    for tile in range(3):
        piece = MapPiece(tile, 0, bytes([CellState.FREE] * TILE_CELLS), ())
        view.take(packet_of(piece), begin_ns + MAP_EVERY_NS // 2 * (1 + tile))
    view.end(begin_ns + 2 * MAP_EVERY_NS)
    view.end(begin_ns + 3 * MAP_EVERY_NS)
    file.close()
    assert file.free == [0, 2 * TILE_CELLS, 3 * TILE_CELLS], "no view of what has not changed"
