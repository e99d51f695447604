# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulated time waits for clients that read late, so that nothing is lost on one machine."""

import asyncio
import struct
import time
from itertools import pairwise
from pathlib import Path

import pytest

from ground.link.radio import RadioLink
from ground.link.wire import encode_request
from ground.requests import Heartbeat
from ground.sim.backlog import DATAGRAM_BYTES, PATIENCE_S, ROOM_BYTES, Backlog
from ground.sim.process import SimulatorProcess
from ground.sim.runtime import Options, Simulator
from ground.sim.world import load_world
from ground.station.station import station_on
from tests.sim.crtp_client import PATIENT, RawClient, packet

BLOCKS = 4
PERIOD_MS = 10
PAUSE_S = 0.5
SETTLED_MS = 3000
BEHIND_MS = 3000
PORT = 0xE0D3
BURST = ROOM_BYTES // DATAGRAM_BYTES
HEAD = "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid\n"


def log_stamps(client: RawClient, until_ms: int) -> dict[int, list[int]]:
    """Time stamps [ms] of each log block, until all have reached a time; stays connected."""
    stamps: dict[int, list[int]] = {block: [] for block in range(BLOCKS)}
    while any(not found or found[-1] < until_ms for found in stamps.values()):
        client.send(15, 3)
        data = client.receive(5, 2)
        stamps[data[0]].append(int.from_bytes(data[1:4], "little"))
    return stamps


def test_a_client_that_does_not_read_for_a_while_loses_nothing() -> None:
    with SimulatorProcess("--world", "empty", "--speed", "max", *PATIENT) as simulator:
        with RawClient(simulator.uri) as client:
            battery, _ = client.toc(5)["pm.vbat"]
            client.fetch_params()
            for block in range(BLOCKS):
                client.ask(5, 1, struct.pack("<BBBH", 6, block, 7, battery))
                client.ask(5, 1, struct.pack("<BBB", 3, block, PERIOD_MS // 10))
            begin_ms = int.from_bytes(client.receive(5, 2)[1:4], "little")
            client.send(15, 3)
            time.sleep(PAUSE_S)
            client.send(15, 3)
            stamps = log_stamps(client, begin_ms + 10_000)
        status = simulator.stop()
    for found in stamps.values():
        assert all(b - a == PERIOD_MS for a, b in pairwise(found))
    assert status["realtime_factor"] > 1


class Table:
    """Simulates what the system shows of one client's socket."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.set(0)

    def set(self, unread_bytes: int, port: int = PORT) -> None:
        row = f"  264: 0100007F:{port:04X} 0100007F:C024 01 00000000:{unread_bytes:08X} 00:00000000"
        self.file.write_text(HEAD + row + " 00000000 0 0 1079345 2 00000000baf82f50 0\n")


def test_the_table_is_read_only_when_a_burst_may_have_filled_the_socket(tmp_path: Path) -> None:
    table = Table(tmp_path / "udp")
    backlog = Backlog(table.file)
    table.set(ROOM_BYTES)
    for _ in range(BURST - 1):
        backlog.sent(PORT, 0.0)
    assert not backlog.clogged(0.0)
    backlog.sent(PORT, 0.0)
    assert backlog.clogged(0.0)
    table.set(ROOM_BYTES // 2)
    assert not backlog.clogged(0.1)
    for _ in range(BURST // 2):
        backlog.sent(PORT, 0.1)
    table.set(ROOM_BYTES)
    assert backlog.clogged(0.1), "half the room: half the burst"


def test_a_client_that_never_reads_is_not_waited_for_until_it_does(tmp_path: Path) -> None:
    table = Table(tmp_path / "udp")
    backlog = Backlog(table.file)

    def fill(unread_bytes: int, now_s: float) -> bool:
        table.set(unread_bytes)
        for _ in range(BURST):
            backlog.sent(PORT, now_s)
        return backlog.clogged(now_s)

    assert fill(ROOM_BYTES, 0.0) and backlog.clogged(0.9 * PATIENCE_S)
    assert not backlog.clogged(1.1 * PATIENCE_S)
    assert not fill(ROOM_BYTES + 5000, 5 * PATIENCE_S)
    assert fill(ROOM_BYTES, 6 * PATIENCE_S), "it has read something"


def test_a_socket_that_is_not_shown_is_known_to_be_unseen(tmp_path: Path) -> None:
    table = Table(tmp_path / "udp")
    table.set(ROOM_BYTES, port=PORT + 1)
    for backlog in (Backlog(table.file), Backlog(tmp_path / "no such file")):
        assert backlog.all_seen
        for _ in range(BURST):
            backlog.sent(PORT, 0.0)
        assert not backlog.clogged(0.0)
        assert not backlog.all_seen


def test_time_waits_for_a_ground_station_that_thinks() -> None:
    async def think() -> tuple[int, int]:
        async with station_on(RadioLink(simulator.uri)) as station:
            while station.picture.drone_ms < SETTLED_MS:
                await asyncio.sleep(0.0)
            before_ms = station.picture.drone_ms
            time.sleep(PAUSE_S)  # nothing that comes meanwhile is looked at
            while station.picture.drone_ms == before_ms:
                await asyncio.sleep(0.0)
            return before_ms, station.picture.drone_ms

    with SimulatorProcess("--world", "empty", "--speed", "max") as simulator:
        before_ms, after_ms = asyncio.run(think())
    assert after_ms - before_ms < BEHIND_MS


def test_time_does_not_wait_for_a_ground_station_that_has_gone() -> None:
    async def listen(seconds: int) -> int:
        async with station_on(RadioLink(simulator.uri)) as station:
            while station.picture.drone_ms < SETTLED_MS + 1000 * seconds:
                await asyncio.sleep(0.0)
            return station.picture.drone_ms

    with SimulatorProcess("--world", "empty", "--speed", "max") as simulator:
        first_ms, second_ms = (asyncio.run(listen(seconds)) for seconds in (0, 10))
    assert SETTLED_MS <= first_ms < second_ms


@pytest.mark.parametrize("listening", [True, False])
def test_time_does_not_stand_still_for_one_that_comes_no_further(listening: bool) -> None:
    simulator = Simulator(load_world("empty"), Options())
    simulator.warm_up()
    hears = [(5, 1, struct.pack("<BBBH", 6, 0, 7, 0)), (5, 1, struct.pack("<BBB", 3, 0, 10))]
    beats = [(13, 2, encode_request(Heartbeat(number, 1))) for number in range(5)]
    for second, beat in enumerate(beats):
        for port, channel, data in (hears if listening and second == 0 else []) + [beat]:
            simulator.radio.receive(("client", 1), packet(port, channel, data), second)
        if second == 0:
            while simulator.time_s < 2 * BEHIND_MS / 1000:
                simulator.step()
        patient = listening and second < 3
        assert simulator.radio.outruns(second) == patient, second
