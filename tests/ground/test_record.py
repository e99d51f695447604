# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording gives back what was heard, even if the program that made it died."""

import asyncio
import json
import os
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from typer.testing import CliRunner

from ground.cli.app import app
from ground.core import MissionCmd, MissionReason, MissionState
from ground.errors import GroundError, LinkUnavailable
from ground.model import Incoming, MapPacket, MapPiece, Point, Pose, Telemetry
from ground.record.codec import KINDS, from_json, to_json
from ground.record.reader import read_recording
from ground.record.recorder import RecordedLink
from ground.record.replay import ReplayLink
from ground.record.writer import RecordFile
from ground.station.station import station_on
from tests.ground.fakelink import FakeLink
from tests.ground.stations import packet_of


@given(st.sampled_from(list(KINDS.values())).flatmap(st.from_type))
def test_every_message_survives_json(message: Incoming) -> None:
    text = json.dumps(to_json(message))
    back = from_json(type(message), json.loads(text))
    assert type(back) is type(message)
    assert json.dumps(to_json(back)) == text


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(st.sampled_from(list(KINDS.values())), json_values)
def test_other_json_is_refused(kind: type[Incoming], data: Any) -> None:  # noqa: ANN401
    with pytest.raises(ValueError):
        from_json(kind, data)


def spoken() -> list[Incoming]:
    """Messages enough for several chunks of a file."""
    telemetry = [
        Telemetry(
            i, Pose(i / 100, 0, 0.4, 0), Point(1, 2), MissionState.FOLLOW, MissionReason.OK, 9
        )
        for i in range(2000)
    ]
    pieces = [packet_of(MapPiece(tile, 0, bytes([2] * 64), ((3, 7),)), tile) for tile in range(256)]
    return [*telemetry, *pieces]


async def record(path: Path) -> None:
    link = FakeLink()
    async with station_on(RecordedLink(link, path)):
        link.say(*spoken())
        while not link.idle:
            await asyncio.sleep(0)


def test_a_recording_is_heard_again(tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    asyncio.run(record(path))
    messages = [message for _, message in read_recording(path)]
    assert [m for m in messages if isinstance(m, Telemetry | MapPacket)] == spoken()

    async def replay() -> None:
        link = ReplayLink(path, speed=1000)
        async with station_on(link) as station:
            await link.finished()
            await asyncio.sleep(0)
            assert station.picture.map.completeness == 1
            assert station.picture.drone_ms == 1999

    asyncio.run(replay())


def test_a_full_disk_ends_the_recording_and_not_the_flight(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    async def run() -> None:
        link = FakeLink()
        recorded = RecordedLink(link, tmp_path / "flight.mcap")
        async with station_on(recorded) as station:
            assert recorded._file is not None
            full = os.open("/dev/full", os.O_WRONLY)
            os.dup2(full, recorded._file._file.fileno())
            os.close(full)
            link.say(*spoken())
            while not link.idle:
                await asyncio.sleep(0)
            await station.command(MissionCmd.LAND)
            assert station.picture.drone_ms == 1999
        assert len(link.acts) == 1

    asyncio.run(run())
    assert "No space left" in caplog.text


def test_a_file_that_was_cut_off_gives_what_is_whole(tmp_path: Path) -> None:
    path = tmp_path / "flight.mcap"
    asyncio.run(record(path))
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2])
    messages = [message for _, message in read_recording(path)]
    assert 100 < len(messages) < len(spoken())


@given(st.integers(0, 4000), st.lists(st.tuples(st.integers(0, 4000), st.integers(1, 255))))
def test_a_damaged_file_never_raises(
    tmp_path_factory: pytest.TempPathFactory, end: int, changes: list[tuple[int, int]]
) -> None:
    path = tmp_path_factory.mktemp("damaged") / "flight.mcap"
    record = RecordFile(path, {"world": "flat"})
    for number, message in enumerate(spoken()[:30]):
        record.note("/Telemetry", message, number)
    record.close()
    data = bytearray(path.read_bytes()[:end])
    for at, mask in changes:
        if at < len(data):
            data[at] ^= mask
    path.write_bytes(data)
    assert all(isinstance(message, Telemetry) for _, message in read_recording(path))


@pytest.mark.parametrize("content", [b"", b"no recording", b"\x89MCAP0\r\n"])
def test_other_files_are_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "other.mcap"
    path.write_bytes(content)
    with pytest.raises(LinkUnavailable, match="not a Wayflie recording"):
        asyncio.run(ReplayLink(path).open())
    result = CliRunner().invoke(app, ["replay", str(path)])
    assert result.exit_code == 1


def test_chunks_are_of_seconds_however_little_is_said(tmp_path: Path) -> None:
    """Data older than two seconds is in the file before it is closed; no chunk is younger."""
    path = tmp_path / "flight.mcap"
    record, second_ns = RecordFile(path, {}), 1_000_000_000
    for number, message in enumerate(spoken()[:100]):
        record.note("/Telemetry", message, number * second_ns // 10)
        heard = [time_s for time_s, _ in read_recording(path)]
        assert number / 10 - max(heard, default=0.0) <= 2.1
    record.close()
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert len(summary.chunk_indexes) == 5


def test_a_missing_file_and_a_bad_folder_are_told(tmp_path: Path) -> None:
    with pytest.raises(LinkUnavailable, match="cannot read"):
        asyncio.run(ReplayLink(tmp_path / "none.mcap").open())
    with pytest.raises(GroundError, match="cannot record"):
        asyncio.run(RecordedLink(FakeLink(), tmp_path / "no" / "f.mcap").open())
