# SPDX-License-Identifier: GPL-3.0-or-later
"""Fly to a goal and rebuild the map: a plain cflib script that knows only the documented bytes.

    python cflib_script.py udp://127.0.0.1:19850 1.5 0.8

Bytes are those of firmware_app/core/wire.h; the states are those of mission.h. The result is
printed as JSON: where the drone says it is, and the grid as text, first row southernmost.
"""

import json
import struct
import sys
import threading
import time
from collections.abc import Callable

import cflib.crtp
from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.syncCrazyflie import SyncCrazyflie

SIDE_CELLS, TILE_CELLS, TILES = 128, 8, 256
IDLE, HOVER, FAULT = 0, 6, 9
GO_TO, LAND = 2, 5
NOT_SETTLED = 5
HELLO_REQUEST = struct.pack("<BBB14x", 2, 1, 1)
LIMIT_S = 100.0

Taker = Callable[[int, dict, LogConfig], None]


class Bits:
    """The payload of a map packet, lowest bit first; zeros after its end."""

    def __init__(self, payload: bytes) -> None:
        self.left = 8 * len(payload)
        self._value = int.from_bytes(payload, "little")

    def take(self, count: int) -> int:
        taken = self._value & ((1 << count) - 1)
        self._value >>= count
        self.left -= count
        return taken


def expected(cells: list[int]) -> int:
    """Predict the state of the next cell from the cells decoded so far."""
    at, side = len(cells), TILE_CELLS
    if at % side == 0:
        return cells[at - side] if at else 0
    if at < side or cells[at - side - 1] != cells[at - 1]:
        return cells[at - 1]
    return cells[at - side]


def mixed_cells(bits: Bits) -> list[int]:
    cells: list[int] = []
    if bits.take(1):
        for _ in range(13):
            five = bits.take(8)
            cells += [five // 3**i % 3 for i in range(5)]
        return cells[:64]
    while len(cells) < 64:
        gap = bits.take(4)
        for _ in range(min(gap, 64 - len(cells))):
            cells.append(expected(cells))
        if gap < 15 and len(cells) < 64:
            cells.append((expected(cells) + 1 + bits.take(1)) % 3)
    return cells


def decode_piece(piece: bytes) -> dict[int, list[int]]:
    """States by tile (0 unknown, 1 free, 2 occupied); points are left out. Empty if damaged."""
    check = 2166136261
    for byte in (piece[1] & 3, piece[0], *piece[3:]):
        check = (check ^ byte) * 16777619 & 0xFFFFFFFF
    if (check ^ check >> 14 ^ check >> 28) & 0x3FFF != piece[1] >> 2 | piece[2] << 6:
        return {}
    tile, bits, tiles = piece[0], Bits(piece[3:]), {}
    while tile < TILES and bits.left >= 2 and (kind := bits.take(2)) < 3:
        if kind < 2:
            for _ in range(bits.take(4) + 1):
                tiles[tile] = [kind] * 64
                tile += 1
            continue
        tiles[tile] = mixed_cells(bits)
        if not bits.take(1):  # not all points fit: nothing else follows
            break
        for _ in range(tiles[tile].count(2)):
            if bits.take(1):
                bits.take(6)
        tile += 1
    return tiles


class Flight:
    """What the drone has reported so far."""

    def __init__(self, cf: Crazyflie) -> None:
        self.cf = cf
        self.tiles: dict[int, list[int]] = {}
        self.status: dict[str, float] = {}
        self.hello: dict[str, object] = {}
        self.console: list[str] = []
        self.heard_s = time.monotonic()
        self.greeted = threading.Event()
        cf.console.receivedChar.add_callback(self.console.append)
        cf.appchannel.packet_received.add_callback(self.take_packet)
        self.log("waymap", 20, [f"m{i}" for i in range(7)], self.take_piece)
        self.log("way", 20, ["state", "fault", "refused", "x", "y"], self.take_status)

    def log(self, group: str, period_ms: int, names: list[str], take: Taker) -> None:
        block = LogConfig(group, period_ms)
        for name in names:
            block.add_variable(f"{group}.{name}")
        self.cf.log.add_config(block)
        block.data_received_cb.add_callback(take)
        block.start()

    def take_packet(self, packet: bytearray) -> None:
        if bytes(packet[:2]) == b"\2\1":
            cell_mm, _, x_m, y_m = struct.unpack("<5xHHff", bytes(packet))
            self.hello = {"cell_m": cell_mm / 1000, "origin_m": [x_m, y_m]}
            self.greeted.set()

    def take_piece(self, time_ms: int, values: dict[str, int], block: LogConfig) -> None:
        words = [values[f"waymap.m{i}"] for i in range(7)]
        self.tiles |= decode_piece(struct.pack("<6IH", *words))

    def take_status(self, time_ms: int, values: dict[str, float], block: LogConfig) -> None:
        self.heard_s = time.monotonic()
        self.status = {name.removeprefix("way."): value for name, value in values.items()}

    def command(self, number: int) -> None:
        self.cf.param.set_value("way.cmd", number)

    def go_to(self, x_m: float, y_m: float) -> None:
        """Send the drone to a goal, as soon as the position estimate has settled."""
        self.cf.param.set_value("way.goalX", x_m)
        self.cf.param.set_value("way.goalY", y_m)

        def gone() -> bool:
            if self.status.get("state", IDLE) == IDLE and self.status.get("refused") == NOT_SETTLED:
                time.sleep(0.1)
                self.command(GO_TO)
            return self.status.get("state", IDLE) != IDLE

        self.command(GO_TO)
        self.wait_for(gone)

    def wait_for(self, condition: Callable[[], bool]) -> None:
        end_s = time.monotonic() + LIMIT_S
        while not condition():
            if time.monotonic() > end_s or self.status.get("state") == FAULT:
                self.give_up()
            time.sleep(0.01)

    def give_up(self) -> None:
        """Report everything that could explain the failure, and exit."""
        held = {name: self.cf.param.get_value(f"way.{name}") for name in ("cmd", "goalX", "goalY")}
        sys.exit(
            f"gave up: {self.status} heard {time.monotonic() - self.heard_s:.1f} s ago, "
            f"{len(self.tiles)} tiles, parameters {held}, console {''.join(self.console)!r}"
        )

    def grid(self) -> list[str]:
        rows = [["?"] * SIDE_CELLS for _ in range(SIDE_CELLS)]
        for tile, states in self.tiles.items():
            y, x = (TILE_CELLS * part for part in divmod(tile, SIDE_CELLS // TILE_CELLS))
            for i, state in enumerate(states):
                rows[y + i // TILE_CELLS][x + i % TILE_CELLS] = "?.#"[state]
        return ["".join(row) for row in rows]


def main(uri: str, goal_x: float, goal_y: float) -> None:
    cflib.crtp.init_drivers()
    with SyncCrazyflie(uri, cf=Crazyflie()) as connected:
        connected.wait_for_params()
        flight = Flight(connected.cf)
        flight.go_to(goal_x, goal_y)
        flight.wait_for(lambda: flight.status["state"] == HOVER)
        arrived = dict(flight.status)
        connected.cf.appchannel.send_packet(HELLO_REQUEST)
        flight.wait_for(flight.greeted.is_set)
        flight.wait_for(lambda: len(flight.tiles) == TILES)
        flight.command(LAND)
        flight.wait_for(lambda: flight.status["state"] == IDLE)
    print(json.dumps({"arrived": arrived, "grid": flight.grid(), **flight.hello}))


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), float(sys.argv[3]))
