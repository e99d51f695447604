# SPDX-License-Identifier: GPL-3.0-or-later
"""What the commands do that talk to one drone. Each returns whether it reached what was asked."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Sequence
from pathlib import Path

from rich.console import Console

from ground.checks import Check, Files, write_report
from ground.core import MissionCmd, MissionReason
from ground.errors import BadInput, NotReached
from ground.flight import Outcome, fly
from ground.link import Link
from ground.link_kept import KeptLink
from ground.link_radio import RadioLink
from ground.mapfile import load_map, save_map
from ground.mapsend import alike, forget_map, send_map
from ground.model import Point, Pose
from ground.nextsteps import after
from ground.progress import line_shown, share_shown, waiting
from ground.record import recorded, where_told
from ground.rosmap import fit, load_ros
from ground.session import (
    explain,
    fly_when_settled,
    keep_connected,
    landing_on_interrupt,
    narrated,
    now,
)
from ground.station import Station, station_on
from ground.web.fleet import Fleet, Member
from ground.web.server import page_server
from ground.words import COMMAND_WORDS

MAP_PATIENCE_S = 30.0


@contextlib.asynccontextmanager
async def _flying(uri: str, files: Files, out: Console) -> AsyncIterator[Station]:
    link = recorded(KeptLink(lambda: RadioLink(uri)), files.recording)
    async with (
        _connected(uri, link, out) as station,
        where_told(link, out),
        narrated(station, out),
        line_shown(out, lambda: now(station)),
        landing_on_interrupt(station, out),
    ):
        yield station


@contextlib.asynccontextmanager
async def _connected(uri: str, link: Link, out: Console) -> AsyncIterator[Station]:
    async with contextlib.AsyncExitStack() as stack:
        with waiting(out, f"connecting to {uri}"):
            station = await stack.enter_async_context(station_on(link))
        yield station


async def fly_to(uri: str, x_m: float, y_m: float, hold: bool, files: Files, out: Console) -> bool:
    """Fly to a point of the map, then land there or hover until Ctrl-C."""
    async with _flying(uri, files, out) as station:
        goal = Point(x_m, y_m)
        outcome = await fly_when_settled(station, MissionCmd.GOTO, goal, out)
        _write_report(station, outcome, files.report)
        if outcome.reached:
            out.print("[green]arrived[/]")
        if outcome.reached and hold:
            out.print("hovering there until Ctrl-C")
            await station.ended()
        if station.picture.state.airborne:
            await fly(station, MissionCmd.LAND)
    return _reached(MissionCmd.GOTO, outcome)


async def fly_mission(uri: str, cmd: MissionCmd, files: Files, out: Console) -> bool:
    """A command without a goal."""
    async with _flying(uri, files, out) as station:
        outcome = await fly_when_settled(station, cmd, None, out)
        _write_report(station, outcome, files.report)
    return _reached(cmd, outcome)


async def fly_along(
    uri: str, cmd: MissionCmd, points: Sequence[Point], files: Files, out: Console
) -> bool:
    """FLY or PATROL along these points, then land."""
    async with _flying(uri, files, out) as station:
        await station.give_waypoints(points)
        return await _fly_and_land(station, cmd, files, out)


async def spin_round(uri: str, turns: float, files: Files, out: Console) -> bool:
    """Turn in place so often, then land."""
    async with _flying(uri, files, out) as station:
        await station.set_parameter("way.turns", turns)
        return await _fly_and_land(station, MissionCmd.SPIN, files, out)


async def _fly_and_land(station: Station, cmd: MissionCmd, files: Files, out: Console) -> bool:
    outcome = await fly_when_settled(station, cmd, None, out)
    _write_report(station, outcome, files.report)
    if station.picture.state.airborne:
        low = outcome.reason is MissionReason.BATTERY_LOW  # it flies home by itself
        await fly(station, MissionCmd.HOME if low else MissionCmd.LAND)
    return _reached(cmd, outcome)


def _reached(cmd: MissionCmd, outcome: Outcome) -> bool:
    if not outcome.reached:
        why = f"could not {COMMAND_WORDS[cmd]}: {explain(outcome)}"
        raise NotReached(why, after(outcome.reason))
    return True


def _write_report(station: Station, outcome: Outcome, json_file: Path | None) -> None:
    if json_file:
        stats = station.stats
        figures = {
            "reached": outcome.reached,
            "reason": outcome.reason.name,
            "sentence": explain(outcome),
            "next_step": after(outcome.reason),
            "place": [outcome.place.x_m, outcome.place.y_m] if outcome.place else None,
            "drone_s": station.picture.drone_ms / 1000,
            "known_cells": station.picture.map.known_cells,
            "map_complete": station.picture.map.completeness,
            "log_packets": stats.log_packets,
            "lost_packets": stats.lost_packets,
        }
        write_report(json_file, figures, [Check("reached", outcome.reached, True, "==")])


async def emergency_stop(uri: str, json_file: Path | None, out: Console) -> bool:
    """Cut the motors."""
    async with _connected(uri, RadioLink(uri), out) as station:
        await station.emergency_stop()
    out.print("stopped: the motors are cut, the drone is locked until it is restarted")
    if json_file:
        write_report(json_file, {"stopped": True}, [])
    return True


async def fetch_map(uri: str, file: Path, json_file: Path | None, out: Console) -> bool:
    """Wait for the whole map and write it."""
    async with _connected(uri, RadioLink(uri), out) as station:
        grid = station.picture.map
        station.ask_snapshot()
        async with share_shown(out, "map", lambda: grid.completeness):
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(MAP_PATIENCE_S):
                    while grid.completeness < 1:
                        await asyncio.sleep(0.1)
        save_map(grid, file)
    out.print(
        f"{file}: {grid.known_cells} known cells, {grid.completeness:.0%} of the map received"
    )
    if json_file:
        figures = {"file": str(file), "known_cells": grid.known_cells}
        write_report(json_file, figures, [Check("map_complete", grid.completeness, 1.0, ">=")])
    return grid.completeness == 1


async def give_map(
    uri: str, file: Path, stands: Pose | None, json_file: Path | None, out: Console
) -> bool:
    """Let the drone have a map from a file; `stands` is where in it the drone is now."""
    arrays = file.suffix.lower() == ".npz"
    if arrays and stands:
        raise BadInput("--pose is for ROS maps: in its own map a drone finds itself")
    ros = None if arrays else load_ros(file)
    async with _connected(uri, RadioLink(uri), out) as station:
        if ros is None:
            kept = load_map(file)
        else:
            await forget_map(station)
            kept = fit(ros, station.picture.map, stands)
        async with share_shown(out, "map", lambda: alike(kept, station.picture.map)):
            await send_map(station, kept)
    out.print(
        f"{kept.known_cells} known cells sent: before it flies on, it finds its place in them"
    )
    if json_file:
        write_report(json_file, {"file": str(file), "known_cells": kept.known_cells}, [])
    return True


async def serve_ground(
    members: list[Member], port: int | None, bind: str, record: Path | None, out: Console
) -> bool:
    """The page for these drones, until Ctrl-C."""
    fleet = Fleet(members)
    several = len(members) > 1
    async with page_server(fleet, port, bind) as address:
        out.print(f"page: [bold]{address}[/]   (Ctrl-C lands and ends)")
        await asyncio.gather(*(keep_connected(member, several, record, out) for member in members))
    return True
