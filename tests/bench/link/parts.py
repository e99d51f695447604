# SPDX-License-Identifier: GPL-3.0-or-later
"""The measurements of `wayflie bench link`, in order: real cflib over real UDP."""

from __future__ import annotations

import asyncio
import os
import signal
import time
from pathlib import Path
from typing import Final

import numpy as np

from ground.core import MissionCmd, MissionState
from ground.errors import CommandRefused, LinkError
from ground.link.kept import KeptLink
from ground.link.radio import INBOX_MESSAGES, RadioLink
from ground.model import LinkState
from ground.sim.process import SimulatorProcess
from ground.station.maps import send_map
from ground.station.settling import fly_when_settled
from ground.station.station import Station, station_on
from tests.bench.link.meter import PACKET_BYTES, Metered, Snapshots, noise_map, until

Figures = dict[str, float | int | None]
MAP_PERIOD_MS: Final = 10
LOSSY: Final = {"loss": 0.3, "duplication": 0.2, "reorder": 0.2}
"""Shares of the packets, each way."""
_LOSSY: Final = tuple(f"--{name}={share}" for name, share in LOSSY.items())
_FADING_S: Final = 26.0
"""So long after a flight the drone's map may still change: what moved fades."""
_COMMANDS: Final = 40
_EPOCHS: Final = 4
_PAGE_BYTES: Final = os.sysconf("SC_PAGE_SIZE")


async def _fetch(uri: str) -> tuple[float, int, int, Station]:
    """A fresh client: link time until the map is complete [s], its packets, its known cells."""
    link = Metered(RadioLink(uri, MAP_PERIOD_MS))
    async with station_on(link) as station:
        complete = await until(lambda: station.picture.map.completeness == 1)
        count = len(link.pieces_ms)
        seconds = (link.pieces_ms[-1] - link.pieces_ms[0]) / 1000 if complete else float("nan")
        return seconds, count, station.picture.map.known_cells, station


async def fetching(seed: int) -> Figures:
    """Fetch the map of an explored home, then a map of noise, which fills every packet."""
    with SimulatorProcess("--world", "flat", "--seed", str(seed), "--speed", "10") as simulator:
        async with station_on(RadioLink(simulator.uri)) as station:
            await fly_when_settled(station, MissionCmd.EXPLORE)
            await until(lambda: station.picture.state is MissionState.IDLE)
        home_s, home_packets, home_cells, _ = await _fetch(simulator.uri)
        async with station_on(RadioLink(simulator.uri, MAP_PERIOD_MS)) as station:
            await send_map(station, noise_map(station.picture.map, seed))
        full_s, full_packets, full_cells, _ = await _fetch(simulator.uri)
    return {
        "map_packets_per_s": 1000 / MAP_PERIOD_MS,
        "home_map_s": home_s,
        "home_known_cells": home_cells,
        "wire_bytes": home_packets * PACKET_BYTES,
        "full_map_s": full_s,
        "full_known_cells": full_cells,
        "full_map_bytes": full_packets * PACKET_BYTES,
    }


async def healing(seed: int) -> Figures:
    """A flight with loss, duplication and reordering; how long the ground's map differs."""
    arguments = ("--world", "flat", "--seed", str(seed), *_LOSSY)
    with SimulatorProcess(*arguments, "--speed", "5") as simulator:
        async with station_on(RadioLink(simulator.uri, MAP_PERIOD_MS)) as station:
            snapshots = Snapshots(station)
            noting = asyncio.create_task(snapshots.run())
            await fly_when_settled(station, MissionCmd.EXPLORE)
            await until(lambda: station.picture.state is MissionState.IDLE)
            landed_ms = station.picture.drone_ms
            await until(lambda: station.picture.drone_ms > landed_ms + 1000 * _FADING_S)
            station.picture.map.clear(station.picture.map.epoch)
            stopped_ms = station.picture.drone_ms
            await until(lambda: station.picture.drone_ms > stopped_ms + 20_000)
            noting.cancel()
            truth = station.picture.map.states.copy()
            known = station.picture.map.known_cells
            stats = station.stats
            events = [event.sequence for event in station.picture.events]
        _, _, again, fresh = await _fetch(simulator.uri)
    same = np.array_equal(truth, fresh.picture.map.states)
    healed_ms = snapshots.equal_from(fresh.picture.map.states)
    return {
        **LOSSY,
        "healed_after_loss_s": (healed_ms - stopped_ms) / 1000 if healed_ms and same else None,
        "healed_known_cells": known if known == again else None,
        "measured_loss": stats.lost_packets / max(1, stats.lost_packets + stats.log_packets),
        "events_missing": events[-1] - events[0] + 1 - len(events),
    }


async def commanding(seed: int) -> Figures:
    """Commands over the same link; each restarts the map, and the drone counts that modulo 4."""
    twice = lost = failed = 0
    arguments = ("--world", "empty", "--seed", str(seed), *_LOSSY)
    with SimulatorProcess(*arguments) as simulator:
        async with station_on(RadioLink(simulator.uri, MAP_PERIOD_MS)) as station:
            epoch = (await station.greet()).epoch
            for _ in range(_COMMANDS):
                told_failed = False
                try:
                    await station.command(MissionCmd.FORGET)
                except (CommandRefused, LinkError):
                    told_failed = True
                await asyncio.sleep(0.1)  # late packets of it arrive
                now = (await station.greet()).epoch
                executed = (now - epoch) % _EPOCHS
                twice += executed > 1
                lost += executed == 0 and not told_failed
                failed += told_failed
                epoch = now
    return {
        "commands": _COMMANDS,
        "commands_executed_twice": twice,
        "commands_lost": lost,
        "commands_reported_failed": failed,
    }


async def breaking(seed: int) -> Figures:
    """The simulator stops answering, dies, and restarts in the middle of a flight."""
    arguments = ("--world", "empty", "--seed", str(seed))
    with SimulatorProcess(*arguments) as simulator:
        port = int(simulator.uri.rpartition(":")[2])
        link = Metered(KeptLink(lambda: RadioLink(simulator.uri)))
        async with station_on(link) as station:
            await fly_when_settled(station, MissionCmd.TAKE_OFF)
            silent_s, heard_s, kept = await _silence(simulator, link, station)
            begin_s = time.monotonic()
            simulator.kill()
            await until(lambda: link.since(begin_s, LinkState.RECONNECTING) is not None)
            dead_s = link.since(begin_s, LinkState.RECONNECTING)
            with SimulatorProcess(*arguments, port=port):
                back_s = time.monotonic()
                await until(lambda: link.since(back_s, LinkState.CONNECTED) is not None)
                await until(lambda: station.picture.telemetry is not None)
                anew = station.picture.state is MissionState.IDLE
                restarted_s = link.since(begin_s, LinkState.RESTARTED)
                known_s = restarted_s + begin_s - back_s if restarted_s is not None else None
                reconnect_s = link.since(back_s, LinkState.CONNECTED)
    return {
        "noticed_silent_s": silent_s,
        "heard_again_s": heard_s,
        "noticed_dead_s": dead_s,
        "noticed_restarted_s": known_s,
        "reconnect_s": reconnect_s,
        "mission_state_right": int(kept and anew),
    }


async def _silence(
    simulator: SimulatorProcess, link: Metered, station: Station
) -> tuple[float | None, float | None, bool]:
    """Seconds until silence is noticed, and until the link recovers; the drone must still fly."""
    process = simulator._process
    assert process is not None
    begin_s = time.monotonic()
    process.send_signal(signal.SIGSTOP)
    await until(lambda: link.since(begin_s, LinkState.SILENT) is not None, 10.0)
    silent_s = link.since(begin_s, LinkState.SILENT)
    again_s = time.monotonic()
    process.send_signal(signal.SIGCONT)
    await until(lambda: link.since(again_s, LinkState.CONNECTED) is not None, 10.0)
    heard_s = link.since(again_s, LinkState.CONNECTED)
    before_ms = station.picture.drone_ms
    await until(lambda: station.picture.drone_ms > before_ms + 500)
    return silent_s, heard_s, station.picture.state.airborne


async def lasting(seed: int, minutes: float) -> Figures:
    """Four drones that explore repeatedly, and what the station costs meanwhile."""
    arguments = ("--world", "flat", "--seed", str(seed), "--endurance", "100000")
    with SimulatorProcess(*arguments, drones=4) as simulator:
        links = [RadioLink(uri) for uri in simulator.uris]
        async with asyncio.TaskGroup() as group:
            ready, over = asyncio.Barrier(len(links) + 1), asyncio.Event()
            for link in links:
                group.create_task(_busy(link, ready, over))
            await ready.wait()
            await asyncio.sleep(10.0)  # what grows only once has grown
            begin_s, begin_cpu_s, begin_mb = time.monotonic(), time.process_time(), memory_mb()
            packets = sum(link.stats.log_packets for link in links)
            await asyncio.sleep(60 * minutes)
            wall_s = time.monotonic() - begin_s
            cpu_s, end_mb = time.process_time() - begin_cpu_s, memory_mb()
            packets = sum(link.stats.log_packets for link in links) - packets
            over.set()
    stats = [link.stats for link in links]
    return {
        "minutes": minutes,
        "station_cpu_share": cpu_s / wall_s,
        "memory_start_mb": begin_mb,
        "memory_end_mb": end_mb,
        "log_packets_per_s": packets / wall_s,
        "queue_in_max": max(link.queue_peak for link in links),
        "queue_in_limit": INBOX_MESSAGES,
        "dropped_messages": sum(each.dropped_messages for each in stats),
    }


async def _busy(link: RadioLink, ready: asyncio.Barrier, over: asyncio.Event) -> None:
    async with station_on(link) as station:
        await ready.wait()
        flying = asyncio.create_task(_explore_forever(station))
        await over.wait()
        flying.cancel()
        await asyncio.wait([flying])


async def _explore_forever(station: Station) -> None:
    while True:
        await fly_when_settled(station, MissionCmd.EXPLORE)
        await asyncio.sleep(1.0)
        await station.command(MissionCmd.FORGET)


def memory_mb() -> float:
    """Resident memory of this process."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * _PAGE_BYTES / 1e6
