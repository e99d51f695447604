# SPDX-License-Identifier: GPL-3.0-or-later
"""The ground's copy of the drone's map, assembled from the tiles that the drone streams."""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ground.core import (
    GRID_SIDE_CELLS,
    MAP_EPOCHS,
    NO_POINT,
    TILE_SIDE_CELLS,
    TILES,
    TILES_PER_ROW,
    CellState,
)
from ground.link.wire import decode_map_piece
from ground.model import Hello, MapPacket, MapPiece, Point

RATE_PACKETS = 64
RESTART_MS = 2000  # a packet older than the newest by more than this means a restarted drone
NEVER_MS = -(1 << 62)

# GroundMap.codes() gives one byte per cell: a CellState, or this with a point in the upper 6 bits.
CODE_POINT = 3


class GroundMap:
    """States and obstacle points of all cells; row 0 is in the south, column 0 in the west.

    `states` (side, side) holds CellState; `eighths` (side, side) holds the obstacle point's place
    within its cell (x in bits 0-2, y in bits 3-5) or NO_POINT. `revision` grows with every change.
    """

    def __init__(self) -> None:
        shape = (GRID_SIDE_CELLS, GRID_SIDE_CELLS)
        self.states: NDArray[np.uint8] = np.zeros(shape, np.uint8)
        self.eighths: NDArray[np.uint8] = np.full(shape, NO_POINT, np.uint8)
        self.tile_seen_s: NDArray[np.float64] = np.full(TILES, -np.inf)
        self.tile_ms: NDArray[np.int64] = np.full(TILES, NEVER_MS)
        self._packets_ms: deque[int] = deque(maxlen=RATE_PACKETS)
        self._drawn: dict[bytes, tuple[int, int]] = {}
        self.cell_m = 0.05
        self.origin = Point(-0.5 * GRID_SIDE_CELLS * 0.05, -0.5 * GRID_SIDE_CELLS * 0.05)
        self.epoch: int | None = None
        self.revision = 0

    def clear(self, epoch: int | None) -> None:
        """Forget everything; from now on only tiles of this epoch are taken (None: of any)."""
        self.states.fill(CellState.UNKNOWN)
        self.eighths.fill(NO_POINT)
        self.tile_seen_s.fill(-np.inf)
        self.tile_ms.fill(NEVER_MS)
        self.epoch = epoch
        self.revision += 1

    def take_hello(self, hello: Hello) -> None:
        """Learn cell size, origin and epoch; if any differs from before, the map is cleared."""
        same = (hello.cell_m, hello.origin, hello.epoch) == (self.cell_m, self.origin, self.epoch)
        self.cell_m, self.origin = hello.cell_m, hello.origin
        if not same:
            self.clear(hello.epoch)

    def take_packet(self, packet: MapPacket, now_s: float) -> None:
        """Apply a map packet; of two packets with the same tile, the one sent later counts."""
        newest_ms = self._packets_ms[-1] if self._packets_ms else packet.drone_ms
        if packet.drone_ms < newest_ms - RESTART_MS:
            self.clear(self.epoch)
            self._packets_ms.clear()
            newest_ms = packet.drone_ms
        self._packets_ms.append(max(packet.drone_ms, newest_ms))
        if self._told_again(packet, now_s):
            return
        tiles = decode_map_piece(packet.data)
        taken = [self.take_piece(piece, now_s, packet.drone_ms) for piece in tiles]
        if len(self._drawn) > TILES:
            self._drawn.clear()
        if all(taken):
            self._drawn[packet.data] = self.revision, len(tiles)

    def _told_again(self, packet: MapPacket, now_s: float) -> bool:
        """Whether the same bytes came before and nothing has changed since; updates tile ages."""
        revision, count = self._drawn.get(packet.data, (-1, 0))
        if revision != self.revision:
            return False
        told = slice(packet.data[0], packet.data[0] + count)
        self.tile_seen_s[told] = now_s
        np.maximum(self.tile_ms[told], packet.drone_ms, out=self.tile_ms[told])
        return True

    def take_piece(self, piece: MapPiece, now_s: float, drone_ms: int = 0) -> bool:
        """Apply one tile; a newer epoch clears the map first. @return False if it is outdated."""
        if self.epoch is None:
            self.epoch = piece.epoch
        ahead = (piece.epoch - self.epoch) % MAP_EPOCHS
        if ahead == MAP_EPOCHS - 1 or drone_ms < self.tile_ms[piece.tile]:
            return False
        if ahead:
            self.clear(piece.epoch)
        window = self._window(piece.tile)
        states = np.frombuffer(piece.states, np.uint8).reshape(TILE_SIDE_CELLS, TILE_SIDE_CELLS)
        kept = NO_POINT if piece.whole else self.eighths[window]
        eighths = np.where(states == CellState.OCCUPIED, kept, NO_POINT).astype(np.uint8)
        for cell, place in piece.points:
            eighths[divmod(cell, TILE_SIDE_CELLS)] = place
        if not (
            np.array_equal(self.states[window], states)
            and np.array_equal(self.eighths[window], eighths)
        ):
            self.states[window] = states
            self.eighths[window] = eighths
            self.revision += 1
        self.tile_seen_s[piece.tile] = now_s
        self.tile_ms[piece.tile] = drone_ms
        return True

    @property
    def rate_hz(self) -> float:
        """Map packets per second, by the drone's clock."""
        if len(self._packets_ms) < 2:
            return 0.0
        return (
            1000 * (len(self._packets_ms) - 1) / max(1, self._packets_ms[-1] - self._packets_ms[0])
        )

    def oldest_tiles(self, than_ms: int, count: int) -> tuple[int, ...]:
        """At most `count` tiles, oldest first, that are older than than_ms at the newest packet."""
        if not self._packets_ms:
            return ()
        old = np.flatnonzero(self._packets_ms[-1] - self.tile_ms > than_ms)
        return tuple(int(tile) for tile in old[np.argsort(self.tile_ms[old])][:count])

    def piece(self, tile: int, epoch: int) -> MapPiece:
        """Make one tile as the drone sends it, with all its points."""
        window = self._window(tile)
        eighths = self.eighths[window].ravel()
        cells = np.flatnonzero(eighths != NO_POINT)
        points = tuple((int(cell), int(eighths[cell])) for cell in cells)
        return MapPiece(tile, epoch, self.states[window].tobytes(), points)

    @property
    def completeness(self) -> float:
        """Share of tiles received since the map was cleared, from 0 to 1."""
        return float(np.mean(np.isfinite(self.tile_seen_s)))

    @property
    def known_cells(self) -> int:
        """Number of observed cells."""
        return int(np.count_nonzero(self.states))

    def tile_ages_s(self, now_s: float) -> NDArray[np.float64]:
        """Seconds since each tile was last received; infinite if never."""
        return now_s - self.tile_seen_s

    def obstacles_m(self) -> NDArray[np.float64]:
        """(n, 2) positions of obstacles: an occupied cell's point, or its centre without one."""
        rows, columns = np.nonzero(self.states == CellState.OCCUPIED)
        eighths = self.eighths[rows, columns]
        none = eighths == NO_POINT
        inside_x = np.where(none, 0.5, ((eighths & 7) + 0.5) / 8)
        inside_y = np.where(none, 0.5, ((eighths >> 3) + 0.5) / 8)
        origin = np.array([self.origin.x_m, self.origin.y_m])
        cells = np.column_stack([columns + inside_x, rows + inside_y])
        return np.asarray(origin + cells * self.cell_m, np.float64)

    def put_points(self, obstacles_m: NDArray[np.float64]) -> None:
        """Set the points of the occupied cells that contain these (n, 2) positions."""
        origin = np.array([self.origin.x_m, self.origin.y_m])
        cells = (obstacles_m.reshape(-1, 2) - origin) / self.cell_m
        columns, rows = np.floor(cells).astype(int).T
        inside = (columns >= 0) & (columns < len(self.states)) & (rows >= 0)
        inside &= rows < len(self.states)
        rows, columns, cells = rows[inside], columns[inside], cells[inside]
        x, y = (8 * (cells % 1)).astype(np.uint8).T
        occupied = self.states[rows, columns] == CellState.OCCUPIED
        self.eighths[rows[occupied], columns[occupied]] = (x + 8 * y)[occupied]

    def codes(self) -> NDArray[np.uint8]:
        """(side, side) codes: a CellState, or CODE_POINT + 4 * eighths where a point is known."""
        points = self.eighths != NO_POINT
        return np.where(points, CODE_POINT + 4 * (self.eighths & 63), self.states).astype(np.uint8)

    def _window(self, tile: int) -> tuple[Any, Any]:
        row, column = divmod(tile, TILES_PER_ROW)
        side = TILE_SIDE_CELLS
        return np.s_[row * side : (row + 1) * side], np.s_[column * side : (column + 1) * side]
