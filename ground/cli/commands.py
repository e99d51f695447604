# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands that talk to one drone; each returns whether it did what was asked."""

from __future__ import annotations

import asyncio
import contextlib
from collections.abc import AsyncIterator, Sequence
from pathlib import Path

from rich.console import Console

from ground.checks import Check, Files, write_report
from ground.cli.session import keep_connected, landing_on_interrupt, narrated, now
from ground.core import MissionCmd, MissionReason
from ground.errors import BadInput, NotReached
from ground.link.kept import KeptLink
from ground.link.protocol import Link
from ground.link.radio import RadioLink
from ground.map.files import load_map, save_map
from ground.map.ros import RosMap, fit, load_ros
from ground.model import Point, Pose
from ground.nextsteps import after
from ground.progress import line_shown, share_shown, waiting
from ground.record.recorder import recorded, where_told
from ground.station.flight import Outcome, fly
from ground.station.maps import alike, await_map, forget_map, send_map
from ground.station.settling import fly_when_settled
from ground.station.station import Station, station_on
from ground.web.fleet import Fleet, Member
from ground.web.server import page_server
from ground.words import COMMAND_WORDS


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
        outcome = await fly_when_settled(station, MissionCmd.GOTO, goal, out.print)
        _write_report(station, outcome, files.report)
        if outcome.reached:
            out.print("[green]arrived[/]")
        if outcome.reached and hold:
            out.print("hovering there until Ctrl-C")
            await station.ended()
        await _bring_down(station, outcome)
    return _reached(MissionCmd.GOTO, outcome)


async def fly_mission(uri: str, cmd: MissionCmd, files: Files, out: Console) -> bool:
    """Give a command that needs no goal, and wait for its outcome."""
    async with _flying(uri, files, out) as station:
        outcome = await fly_when_settled(station, cmd, None, out.print)
        _write_report(station, outcome, files.report)
    return _reached(cmd, outcome)


async def fly_along(
    uri: str, cmd: MissionCmd, points: Sequence[Point], files: Files, out: Console
) -> bool:
    """Fly or patrol along these points, then land."""
    async with _flying(uri, files, out) as station:
        await station.give_waypoints(points)
        return await _fly_and_land(station, cmd, files, out)


async def spin_round(uri: str, turns: float, files: Files, out: Console) -> bool:
    """Turn in place so many times, then land."""
    async with _flying(uri, files, out) as station:
        await station.set_parameter("way.turns", turns)
        return await _fly_and_land(station, MissionCmd.SPIN, files, out)


async def _fly_and_land(station: Station, cmd: MissionCmd, files: Files, out: Console) -> bool:
    outcome = await fly_when_settled(station, cmd, None, out.print)
    _write_report(station, outcome, files.report)
    await _bring_down(station, outcome)
    return _reached(cmd, outcome)


async def _bring_down(station: Station, outcome: Outcome) -> None:
    if station.picture.state.airborne:
        low = outcome.reason is MissionReason.BATTERY_LOW  # the drone flies home by itself
        await fly(station, MissionCmd.HOME if low else MissionCmd.LAND)


def _reached(cmd: MissionCmd, outcome: Outcome) -> bool:
    if not outcome.reached:
        why = f"could not {COMMAND_WORDS[cmd]}: {outcome.told}"
        raise NotReached(why, after(outcome.reason))
    return True


def _write_report(station: Station, outcome: Outcome, json_file: Path | None) -> None:
    if json_file:
        stats = station.stats
        figures = {
            "reached": outcome.reached,
            "reason": outcome.reason.name,
            "sentence": outcome.told,
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
    """Stop the motors at once."""
    async with _connected(uri, RadioLink(uri), out) as station:
        await station.emergency_stop()
    out.print("stopped: the motors are cut; the drone stays locked until it is restarted")
    if json_file:
        write_report(json_file, {"stopped": True}, [])
    return True


async def fetch_map(uri: str, file: Path, json_file: Path | None, out: Console) -> bool:
    """Fetch the whole map and write it to a file."""
    async with _connected(uri, RadioLink(uri), out) as station:
        grid = station.picture.map
        async with share_shown(out, "map", lambda: grid.completeness):
            await await_map(station)
        save_map(grid, file)
    told = f"{grid.known_cells} known cells, {grid.completeness:.0%} of the map received"
    out.print(f"{file}: {told}", soft_wrap=True)
    if json_file:
        figures = {"file": str(file), "known_cells": grid.known_cells}
        write_report(json_file, figures, [Check("map_complete", grid.completeness, 1.0, ">=")])
    if grid.completeness < 1:
        raise NotReached("part of the map was not received", "come nearer; again with --force")
    return True


async def give_map(
    uri: str, file: Path, stands: Pose | None, json_file: Path | None, out: Console
) -> bool:
    """Load a map from a file into the drone; `stands` is the drone's present pose in it."""
    arrays = file.suffix.lower() == ".npz"
    if arrays and stands:
        raise BadInput("--pose is for ROS maps: in its own map a drone finds its place by itself")
    found = load_map(file) if arrays else load_ros(file)
    async with _connected(uri, RadioLink(uri), out) as station:
        if isinstance(found, RosMap):
            await forget_map(station)
            kept = fit(found, station.picture.map, stands)
        else:
            kept = found
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
    """Serve the page for these drones, until Ctrl-C."""
    fleet = Fleet(members)
    several = len(members) > 1
    async with page_server(fleet, port, bind) as address:
        out.print(f"page: [bold]{address}[/]   (Ctrl-C lands and ends)")
        await asyncio.gather(*(keep_connected(member, several, record, out) for member in members))
    return True
