# SPDX-License-Identifier: GPL-3.0-or-later
"""What the simulated drone answers, byte by byte, to a client that knows only the protocol."""

import random
import struct
import time
import zlib
from collections.abc import Iterator
from itertools import pairwise

import pytest

from ground.sim.process import SimulatorProcess
from tests.sim.crtp_client import PATIENT, RawClient, wait_until

PARAM, LOG, LINK, PLATFORM = 2, 5, 15, 13
ENOENT, E2BIG, EEXIST, EACCES, EINVAL, EBUSY = 2, 7, 17, 13, 22, 16
UINT8, UINT16, UINT32, INT16, FLOAT, FP16 = 1, 2, 3, 5, 7, 8


@pytest.fixture(scope="module")
def simulator() -> Iterator[SimulatorProcess]:
    with SimulatorProcess("--world", "empty", "--profile", "perfect", *PATIENT) as running:
        yield running


@pytest.fixture
def client(simulator: SimulatorProcess) -> Iterator[RawClient]:
    with RawClient(simulator.uri) as raw:
        raw.ask(LOG, 1, b"\5")
        yield raw


def block_of(client: RawClient, number: int, kinds: list[tuple[str, int]]) -> bytes:
    table = client.toc(LOG)
    variables = b"".join(struct.pack("<BH", kind, table[name][0]) for name, kind in kinds)
    return bytes((6, number)) + variables


def test_link_source_echo_and_versions(client: RawClient) -> None:
    assert client.ask(LINK, 1, b"\0") == b"Bitcraze Crazyflie".ljust(30, b"\0")
    ping = b"\0" + struct.pack("<d", 1.5)
    assert client.ask(LINK, 0, ping) == ping
    assert client.ask(PLATFORM, 1, b"\0") == b"\0" + struct.pack("<i", 12)
    assert client.ask(PLATFORM, 1, b"\1")[0] == 1
    assert client.ask(PLATFORM, 1, b"\2") == b"\2Crazyflie 2.1"


def test_scan_probe_is_answered_and_makes_no_client(simulator: SimulatorProcess) -> None:
    with RawClient(simulator.uri) as watcher, RawClient(simulator.uri) as probe:
        watcher.fetch_params()
        parameters = watcher.toc(PARAM)
        probe.send_raw(b"\xff")
        assert probe.receive_raw() == b"\xff"
        # A client would now be told about this; the probe's socket must stay silent.
        identity, _ = parameters["way.goalX"]
        watcher.ask(PARAM, 2, struct.pack("<Hf", identity, 0.25))
        probe.send_raw(b"\xff")
        assert probe.receive_raw() == b"\xff"


def test_tables_are_complete_bare_and_different(client: RawClient) -> None:
    log, parameters = client.toc(LOG), client.toc(PARAM)
    assert {kind for _, kind in log.values()} <= set(range(1, 8))
    assert {"way.state", "stateEstimate.x", "supervisor.info", "sys.canfly"} <= log.keys()
    assert {"way.goalX", "deck.bcFlow2", "commander.enHighLevel"} <= parameters.keys()
    assert parameters["deck.bcFlow2"][1] & 0x40
    assert all(len(name) <= 25 for name in log.keys() | parameters.keys())
    info_log, info_param = client.ask(LOG, 0, b"\3"), client.ask(PARAM, 0, b"\3")
    assert info_log[7:] == bytes((16, 128)) and len(info_param) == 7
    assert info_log[3:7] != info_param[3:7]
    assert client.ask(LOG, 0, struct.pack("<BH", 2, len(log))) == b"\2"


def test_parameter_read_write_and_errors(client: RawClient) -> None:
    table = client.toc(PARAM)
    goal, _ = table["way.goalX"]
    write = struct.pack("<Hf", goal, 1.25)
    assert client.ask(PARAM, 2, write) == write
    assert client.ask(PARAM, 1, write[:2]) == write[:2] + b"\0" + write[2:]
    assert client.ask(PARAM, 2, b"\xf0\xff\0") == bytes((0xF0, 0xFF, ENOENT))
    read_only = struct.pack("<HB", table["deck.bcFlow2"][0], 0)
    client.send(PARAM, 2, read_only)
    assert client.ask(PARAM, 1, read_only[:2]) == read_only[:2] + b"\0\1"


def test_parameter_by_name(client: RawClient) -> None:
    def set_by_name(name: bytes, kind: int, value: bytes) -> int:
        head = b"\0" + name + b"\0"
        answer = client.ask(PARAM, 3, head + bytes((kind,)) + value)
        assert answer[:-1] == head
        return answer[-1]

    four = struct.pack("<f", 4.0)
    assert set_by_name(b"way\0goalY", 6, four) == 0
    goal = struct.pack("<H", client.toc(PARAM)["way.goalY"][0])
    assert client.ask(PARAM, 1, goal) == goal + b"\0" + four
    assert set_by_name(b"way\0nothing", 6, four) == ENOENT
    assert set_by_name(b"way\0goalY", 8, b"\1") == EINVAL
    assert set_by_name(b"deck\0bcFlow2", 8, b"\0") == EACCES


def test_default_and_persistent_values(client: RawClient) -> None:
    table = client.toc(PARAM)
    height = struct.pack("<H", table["way.height"][0])
    assert table["way.height"][1] & 0x10
    assert client.ask(PARAM, 3, b"\7" + height) == b"\7" + height + b"\0\1"
    default = client.ask(PARAM, 3, b"\x08" + height)
    assert default[:4] == b"\x08" + height + b"\0" and len(default) == 8
    assert client.ask(PARAM, 3, b"\4" + height) == b"\4" + height + b"\0" + default[4:]
    new = struct.pack("<f", 0.625)
    client.ask(PARAM, 2, height + new)
    assert client.ask(PARAM, 3, b"\3" + height) == b"\3" + height + b"\0"
    assert client.ask(PARAM, 3, b"\4" + height) == b"\4" + height + b"\1" + default[4:] + new
    assert client.ask(PARAM, 3, b"\5" + height) == b"\5" + height + b"\0"
    assert client.ask(PARAM, 3, b"\5" + height) == b"\5" + height + bytes((ENOENT,))
    client.ask(PARAM, 2, height + default[4:])
    read_only = struct.pack("<H", table["deck.bcFlow2"][0])
    assert client.ask(PARAM, 3, b"\x08" + read_only)[3] == ENOENT


def test_a_write_is_news_for_other_clients(simulator: SimulatorProcess) -> None:
    with RawClient(simulator.uri) as one, RawClient(simulator.uri) as other:
        other.fetch_params()
        one.fetch_params()
        write = struct.pack("<Hf", one.toc(PARAM)["way.goalX"][0], 0.5)
        assert one.ask(PARAM, 2, write) == write
        while (news := other.receive(PARAM, 3)) != b"\1" + write:
            assert news[0] == 1


def test_log_block_with_dangling_byte_append_and_conversions(client: RawClient) -> None:
    table = client.toc(LOG)
    battery = struct.pack("<H", table["pm.vbat"][0])
    client.ask(LOG, 1, b"\6\7" + bytes((FLOAT | FLOAT << 4,)) + battery + bytes((UINT8,)))
    assert client.ask(LOG, 1, b"\3\7\2") == b"\3\7\0"
    extra = bytes((UINT8,)) + battery + bytes((FP16,)) + battery + bytes((INT16,)) + battery
    assert client.ask(LOG, 1, b"\7\7" + extra) == b"\7\7\0"
    while len(data := client.receive(LOG, 2)) < 13:
        assert len(data) == 8
    volts, byte, half, word = struct.unpack("<fBeh", data[4:])
    assert 3.0 < volts < 4.3
    assert byte == int(volts) == word and half == pytest.approx(volts, abs=0.01)


def test_log_times_are_exact_and_by_function_variables_get_them(client: RawClient) -> None:
    create = block_of(client, 1, [(f"waymap.m{i}", UINT32) for i in range(6)])
    assert client.ask(LOG, 1, create) == b"\6\1\0"
    assert client.ask(LOG, 1, b"\x08\1" + struct.pack("<H", 15)) == b"\x08\1\0"
    stamps = [int.from_bytes(client.receive(LOG, 2)[1:4], "little") for _ in range(20)]
    assert [b - a for a, b in pairwise(stamps)] == [15] * 19


def test_log_errors_are_the_firmwares(client: RawClient) -> None:
    create = block_of(client, 2, [("stateEstimate.x", FLOAT)] * 6)
    assert client.ask(LOG, 1, create)[2] == 0
    assert client.ask(LOG, 1, create)[2] == EEXIST
    assert client.ask(LOG, 1, b"\7" + create[1:5])[2] == E2BIG
    assert client.ask(LOG, 1, b"\6\3" + struct.pack("<BH", FLOAT, 0xFFFF))[2] == ENOENT
    for command in (b"\2\x63", b"\3\x63\1", b"\4\x63"):
        assert client.ask(LOG, 1, command)[2] == ENOENT
    assert client.ask(LOG, 1, b"\2\2") == b"\2\2\0"
    assert client.ask(LOG, 1, b"\2\2")[2] == ENOENT


def test_memory_is_empty_and_every_access_fails(client: RawClient) -> None:
    assert client.ask(4, 0, b"\1") == b"\1\0"
    assert client.ask(4, 1, b"\0\0\0\0\0\x18") == b"\0\0\0\0\0\5"
    assert client.ask(4, 2, b"\0\0\0\0\0\1\2") == b"\0\0\0\0\0\5"


def test_app_channel_reaches_the_app_and_all_clients(simulator: SimulatorProcess) -> None:
    version, command, ack, sequence, nonsense = 2, 2, 3, 0x1234, 99
    with RawClient(simulator.uri) as one, RawClient(simulator.uri) as other:
        other.ask(LINK, 1)
        request = struct.pack("<BBHBff", version, command, sequence, nonsense, 0.0, 0.0)
        one.send(PLATFORM, 2, request)
        expected = struct.pack("<BBHB", version, ack, sequence, nonsense)
        for client in (one, other):
            while not (answer := client.receive(PLATFORM, 2)).startswith(expected):
                assert answer[0] == version


def test_supervisor_states(client: RawClient) -> None:
    info = client.ask(9, 0, b"\x0c")
    assert info[0] == 0x8C and len(info) == 3
    assert client.ask(9, 0, b"\3") == b"\x83" + bytes((info[1] >> 2 & 1,))
    assert client.ask(9, 1, b"\2") == b"\x82\1\1"


def test_high_level_refusals(client: RawClient) -> None:
    spiral = struct.pack("<BBBB5f", 11, 0, 0, 0, 1, 1, 1, 0, 1)
    assert client.ask(8, 0, spiral) == spiral[:3] + b"\x08"
    never = struct.pack("<BBff?f", 7, 0, 0.5, 0, False, 0.0)
    assert client.ask(8, 0, never)[3] == EINVAL


def test_a_silent_client_loses_its_log_blocks() -> None:
    def forgotten() -> bool:
        time.sleep(1.5)
        return client.ask(LOG, 1, b"\4\4") == bytes((4, 4, ENOENT))

    with (
        SimulatorProcess("--world", "empty", "--profile", "perfect") as simulator,
        RawClient(simulator.uri) as client,
    ):
        client.ask(LOG, 1, block_of(client, 4, [("pm.vbat", FLOAT)]))
        client.ask(LOG, 1, b"\3\4\2")
        client.receive(LOG, 2)
        wait_until(forgotten, "it was forgotten")
        assert client.ask(LOG, 1, b"\3\4\2") == bytes((3, 4, ENOENT))


def test_noise_is_dropped_and_counted() -> None:
    noise = random.Random(7)
    with SimulatorProcess("--world", "empty", "--profile", "perfect") as simulator:
        with RawClient(simulator.uri) as vandal, RawClient(simulator.uri) as client:
            for count in range(3000):
                size = noise.choice((0, 1, 2, 3, 5, 9, 18, 31, 32, 200))
                vandal.send_raw(noise.randbytes(size))
                if count % 50 == 0:
                    client.ask(LINK, 1)
            assert client.ask(LINK, 1)[:8] == b"Bitcraze"
            assert zlib.crc32(client.ask(LINK, 0, b"still here")) == zlib.crc32(b"still here")
        status = simulator.stop()
    assert status["bad_packets"] > 1000
    assert sum(status["bad_packet_reasons"].values()) == status["bad_packets"]
    assert status["app_alive"]
