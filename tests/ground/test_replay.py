# SPDX-License-Identifier: GPL-3.0-or-later
"""A recording can be paused and moved to any time, and the picture is that of the time."""

import asyncio
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest

from ground.core import MissionReason, MissionState
from ground.model import Hello, MapPiece, Point, Pose, Telemetry
from ground.record.recorder import RecordedLink
from ground.record.replay import ReplayLink
from ground.record.writer import RecordFile
from ground.station.picture import Picture
from ground.station.station import Station, station_on
from ground.web.cockpit import Cockpit
from ground.web.frames import NOTHING, state_frame
from ground.web.wishes import wind
from tests.ground.fakelink import HELLO
from tests.ground.stations import packet_of

LENGTH_S = 60


def told(second: int) -> Telemetry:
    pose = Pose(float(second), 0.0, 0.4, 0.0)
    return Telemetry(
        5000 + 1000 * second, pose, Point(0, 0), MissionState.FOLLOW, MissionReason.OK, 100
    )


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """A minute of flight; each second another tile becomes known."""
    path = tmp_path / "flight.mcap"
    record = RecordFile(path, {})
    for second in range(LENGTH_S + 1):
        record.note("/Telemetry", told(second), second)
        record.note(
            "/MapPacket", packet_of(MapPiece(second, 0, bytes([1] * 64), ()), second), second
        )
        if second == 0:
            record.note("/Hello", HELLO, second)
    record.close()
    return path


def with_replay(file: Path, work: Callable[[ReplayLink, Station], Awaitable[None]]) -> None:
    async def run() -> None:
        link = ReplayLink(file)
        async with station_on(link) as station:

            def forget() -> None:
                station.picture = Picture()

            link.on_rewind = forget
            link.pause()
            await work(link, station)

    asyncio.run(run())


async def at(station: Station, second: int) -> None:
    """Wait until the replay shows that second."""
    while station.picture.telemetry != told(second):
        await asyncio.sleep(0.001)


def test_it_goes_by_the_drones_clock(file: Path) -> None:
    async def work(link: ReplayLink, station: Station) -> None:
        assert link.duration_s == pytest.approx(LENGTH_S)

    with_replay(file, work)


def test_the_map_grows_and_shrinks_with_time(file: Path) -> None:
    async def work(link: ReplayLink, station: Station) -> None:
        for second in (40, 10, 11, 60, 0):
            link.seek(float(second))
            await at(station, second)
            await asyncio.sleep(0.01)
            assert station.picture.map.known_cells == 64 * (second + 1)
            assert link.position_s == pytest.approx(second)
            assert not link.playing
            assert len(station.picture.trail) == second + 1

    with_replay(file, work)


def test_the_end_is_not_the_end(file: Path) -> None:
    async def work(link: ReplayLink, station: Station) -> None:
        link.seek(1e9)
        await link.finished()
        await at(station, LENGTH_S)
        link.speed = 1000.0
        link.play()
        await at(station, 1)
        await at(station, LENGTH_S)

    with_replay(file, work)


def test_a_page_shows_and_winds_it(file: Path) -> None:
    async def work(link: ReplayLink, station: Station) -> None:
        cockpit = Cockpit(station)
        assert '"replay": null' in state_frame(cockpit, NOTHING)[0]
        cockpit.timeline = link
        for wish in ({"s": 7}, {"s": "x"}, {"s": float("nan")}, {}):
            wind(link, {"do": "seek", **wish})
        await at(station, 7)
        text, _ = state_frame(cockpit, NOTHING)
        assert '"replay": {"at_s": 7.0, "of_s": 60.0, "playing": false}' in text
        assert '"goto": false' in text
        wind(link, {"do": "play"})
        assert link.playing
        wind(link, {"do": "pause"})
        assert not link.playing

    with_replay(file, work)


def test_an_old_recording_is_not_overwritten(file: Path) -> None:
    from ground.errors import GroundError
    from tests.ground.fakelink import FakeLink

    with pytest.raises(GroundError, match="exists already"):
        asyncio.run(RecordedLink(FakeLink(), file).open())


def test_hello_is_heard(file: Path) -> None:
    async def work(link: ReplayLink, station: Station) -> None:
        assert isinstance(station.picture.hello, Hello)

    with_replay(file, work)
