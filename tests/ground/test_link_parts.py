# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts of the radio link: the queue between threads, log packets, log blocks."""

import asyncio
import math
import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ground.core import MissionState, Source
from ground.link.inbox import Inbox
from ground.link.logblocks import LogBlock, Values, decode_source, decode_telemetry, log_blocks
from ground.link.logstream import CLOCK_MS, LogStream
from ground.model import LogMessage, Positioned, Ranges, Telemetry
from ground.words import SOURCE_WORDS

BYTES = {"uint8_t": 1, "uint16_t": 2, "FP16": 2, "uint32_t": 4, "float": 4}


def test_blocks_fit_into_one_packet_each() -> None:
    for block in log_blocks(20):
        assert sum(BYTES[kind] for _, kind in block.variables) <= 26, block.name
        assert len(block.variables) <= 9, block.name
        assert block.period_ms in range(10, 2541, 10)


@given(st.dictionaries(st.sampled_from([n for n, _ in log_blocks(20)[0].variables]), st.floats()))
def test_odd_telemetry_is_refused_without_raising(odd: dict[str, float]) -> None:
    values = {name: 1.0 for name, _ in log_blocks(20)[0].variables} | odd
    message = decode_telemetry(5, values)
    if message is not None:
        assert isinstance(message, Telemetry)
        assert math.isfinite(message.pose.x_m + message.pose.yaw_rad)


def test_telemetry_is_in_radians_and_words() -> None:
    values = {name: 0.0 for name, _ in log_blocks(20)[0].variables}
    message = decode_telemetry(7, values | {"way.yaw": 90.0, "way.state": 6})
    assert isinstance(message, Telemetry)
    assert message.pose.yaw_rad == pytest.approx(math.pi / 2)
    assert message.state is MissionState.HOVER


def test_ranges_know_nothing_from_near() -> None:
    block = next(block for block in log_blocks(20) if block.name == "ranges")
    values = dict(zip([n for n, _ in block.variables], [1500, 32767, 0, 20, 4000], strict=True))
    assert block.decode(1, values) == Ranges(1, 1.5, None, None, 0.02, 4.0)


class Recorder:
    """A log block of period 20 ms and the messages that come out of it."""

    def __init__(self) -> None:
        self.times_ms: list[int] = []
        block = LogBlock("test", 20, (), self._decode)
        self.stream = LogStream(block, lambda message: None)

    def _decode(self, drone_ms: int, values: Values) -> LogMessage | None:
        self.times_ms.append(drone_ms)
        return None


@given(st.integers(0, CLOCK_MS - 1), st.lists(st.booleans(), min_size=1, max_size=200))
def test_gaps_are_counted_and_time_goes_on_over_the_wrap(start: int, arrives: list[bool]) -> None:
    recorder = Recorder()
    times = [start + 20 * i for i, came in enumerate(arrives) if came]
    for time_ms in times:
        recorder.stream.take(time_ms % CLOCK_MS, {})
    if times:
        expected = (times[-1] - times[0]) // 20 + 1 - len(times)
        assert recorder.stream.lost == expected
        steps = zip(recorder.times_ms, recorder.times_ms[1:], strict=False)
        assert all(before < after for before, after in steps)
    assert recorder.stream.received == recorder.stream.bad == len(times)


def test_a_restart_is_no_loss() -> None:
    recorder = Recorder()
    for time_ms in (500_000, 500_020, 40, 60):
        recorder.stream.take(time_ms, {})
    assert recorder.stream.lost == 0
    assert recorder.times_ms[-1] == 60


def test_a_block_that_never_comes_is_overdue_again_and_again() -> None:
    stream = Recorder().stream
    assert stream.overdue(100.0, 0)
    assert not stream.overdue(100.3, 0)
    assert stream.overdue(101.0, 0)


def test_a_fast_simulation_is_overdue_by_its_own_clock() -> None:
    stream = Recorder().stream
    assert stream.overdue(100.0, 50_000)
    assert not stream.overdue(100.05, 52_000), "its answer may be on the way"
    assert not stream.overdue(100.2, 50_500)
    assert stream.overdue(100.2, 52_000)


def test_inbox_keeps_order_and_counts_what_it_drops() -> None:
    async def run() -> None:
        inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), capacity=100)
        filler = threading.Thread(target=lambda: [inbox.put(i) for i in range(250)])
        filler.start()
        filler.join()
        assert await inbox.take() == list(range(150, 250))
        assert inbox.dropped == 150
        inbox.put(7)
        inbox.close()
        assert await inbox.take() == [7]
        assert await inbox.take() == []

    asyncio.run(run())


def test_inbox_loses_nothing_between_two_running_threads() -> None:
    async def run() -> list[int]:
        inbox: Inbox[int] = Inbox(asyncio.get_running_loop(), capacity=100_000)
        filler = threading.Thread(target=lambda: [inbox.put(i) for i in range(20_000)])
        filler.start()
        got: list[int] = []
        while len(got) < 20_000:
            got += await inbox.take()
        filler.join()
        return got

    assert asyncio.run(run()) == list(range(20_000))


def test_inbox_outlives_its_loop() -> None:
    async def make() -> Inbox[int]:
        return Inbox(asyncio.get_running_loop(), capacity=2)

    inbox = asyncio.run(make())
    for item in range(3):
        inbox.put(item)
    inbox.close()
    assert inbox.dropped == 1


def test_every_source_of_the_pose_has_words() -> None:
    for source in Source:
        assert decode_source(7, {"way.source": float(source)}) == Positioned(7, source)
        assert SOURCE_WORDS[source]
    assert decode_source(7, {"way.source": 6.0}) is None  # of a newer app
