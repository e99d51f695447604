# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie demo`: simulator, station and page together, and a flight into another room."""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
import webbrowser
from collections.abc import AsyncIterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console

from ground.checks import Check, write_report
from ground.cli.session import landing_on_interrupt, narrated, now
from ground.core import MissionCmd
from ground.errors import GroundError
from ground.link.radio import RadioLink
from ground.map.groundmap import GroundMap
from ground.model import LinkStats, Point
from ground.progress import line_shown, waiting
from ground.record.recorder import recorded, where_told
from ground.sim.process import SimulatorProcess
from ground.sim.world import World, load_world
from ground.station.flight import Outcome, fly
from ground.station.maps import await_map
from ground.station.settling import fly_when_settled
from ground.station.station import Station, station_on
from ground.web.cockpit import Cockpit
from ground.web.fleet import Fleet
from ground.web.server import page_server

GOAL_ERROR_M = 0.5  # limit for the true position at the end, as odometry drifts on the way
MAP_ERROR_M = 0.25


@dataclass(frozen=True, slots=True)
class DemoOptions:
    """Options of the demo."""

    world: str = "flat"
    headless: bool = False
    seed: int = 1
    port: int | None = None
    json_file: Path | None = None
    recording: Path | None = None


@dataclass(frozen=True, slots=True)
class _Flight:
    """The flight as the ground station saw it."""

    outcome: Outcome
    landed: bool
    grid: GroundMap
    stats: LinkStats


async def run_demo(options: DemoOptions, out: Console) -> bool:
    """Run the demo. @return whether every check of the report holds"""
    world = load_world(options.world)
    if world.spec.demo_goal_m is None:
        raise GroundError(f"the world {options.world} names no goal in a table [demo]")
    goal = Point(*world.spec.demo_goal_m)
    speed = "max" if options.headless else "1"
    begin_s = time.monotonic()
    arguments = ("--world", options.world, "--speed", speed, "--seed", str(options.seed))
    simulator = SimulatorProcess(*arguments)
    with contextlib.ExitStack() as stack:
        with waiting(out, "starting the simulator"):
            stack.enter_context(simulator)
        link = recorded(RadioLink(simulator.uri), options.recording)
        async with (
            station_on(link) as station,
            where_told(link, out),
            _shown(station, options, out),
        ):
            out.print(f"goal ({goal.x_m:.2f}, {goal.y_m:.2f}) in the world `{options.world}`")
            flight = await _fly(station, goal, out)
            wall_s = time.monotonic() - begin_s
            if not options.headless:
                await _stay(station, out)
        truth = simulator.stop()
    figures = _figures(flight, truth, world, goal) | {"wall_s": round(wall_s, 2)}
    checks = _checks(figures)
    _print_figures(figures, checks, out)
    if options.json_file:
        write_report(options.json_file, figures, checks)
    return all(check.ok for check in checks)


@contextlib.asynccontextmanager
async def _shown(station: Station, options: DemoOptions, out: Console) -> AsyncIterator[None]:
    """Show the page, unless headless, and a narration; land on Ctrl-C."""
    async with contextlib.AsyncExitStack() as stack:
        if not options.headless:
            address = await stack.enter_async_context(
                page_server(Fleet.of(Cockpit(station)), options.port)
            )
            opened = await asyncio.to_thread(webbrowser.open, address)
            out.print(f"page: [bold]{address}[/]{'' if opened else '  (open it in a browser)'}")
        await stack.enter_async_context(narrated(station, out))
        await stack.enter_async_context(line_shown(out, lambda: now(station)))
        await stack.enter_async_context(landing_on_interrupt(station, out))
        yield


async def _fly(station: Station, goal: Point, out: Console) -> _Flight:
    outcome = await fly_when_settled(station, MissionCmd.GOTO, goal, out.print)
    landed = not station.picture.state.airborne
    if outcome.reached:
        out.print("[green]arrived[/]; landing there")
    else:
        out.print(f"[red]not reached: {outcome.told}[/]")
    if not landed:
        landed = (await fly(station, MissionCmd.LAND)).reached
    await await_map(station)
    return _Flight(outcome, landed, station.picture.map, station.stats)


async def _stay(station: Station, out: Console) -> None:
    """Stay until Ctrl-C, which is the normal end of the demo."""
    out.print("now click on the map to send it somewhere else; Ctrl-C lands and ends")
    try:
        await station.ended()
    except asyncio.CancelledError:
        if station.picture.state.airborne:
            raise
        task = asyncio.current_task()
        if task:
            task.uncancel()


def _figures(flight: _Flight, truth: dict[str, Any], world: World, goal: Point) -> dict[str, Any]:
    x_m, y_m, *_ = truth["true_pose"]
    goal_error_m = math.dist((x_m, y_m), world.to_world(goal.x_m, goal.y_m))
    return {
        "reached": flight.outcome.reached and goal_error_m <= GOAL_ERROR_M,
        "landed": flight.landed,
        "sentence": flight.outcome.told,
        "goal_error_m": round(goal_error_m, 3),
        "collisions": truth["collisions"],
        "path_m": truth["path_m"],
        "sim_s": truth["sim_s"],
        "realtime_factor": truth["realtime_factor"],
        "known_cells": flight.grid.known_cells,
        "map_complete": round(flight.grid.completeness, 3),
        "map_error_m": map_error_m(flight.grid, world),
        "log_packets": flight.stats.log_packets,
        "lost_packets": flight.stats.lost_packets,
        "bad_packets": flight.stats.bad_packets,
        "dropped_messages": flight.stats.dropped_messages,
    }


def map_error_m(grid: GroundMap, world: World) -> float | None:
    """Median distance of mapped obstacles to the nearest true surface; None without obstacles."""
    obstacles_m = grid.obstacles_m()
    if not len(obstacles_m):
        return None
    x_m, y_m = world.to_world(obstacles_m[:, 0], obstacles_m[:, 1])
    distances_m = world.surface_distance_m(np.column_stack([x_m, y_m]))
    return round(float(np.median(np.abs(distances_m))), 4)


def _checks(figures: dict[str, Any]) -> list[Check]:
    return [
        Check("reached", figures["reached"], True, "=="),
        Check("landed", figures["landed"], True, "=="),
        Check("collisions", figures["collisions"], 0, "=="),
        Check("map_error_m", figures["map_error_m"], MAP_ERROR_M, "<="),
    ]


def _print_figures(figures: dict[str, Any], checks: list[Check], out: Console) -> None:
    failed = {check.name for check in checks if not check.ok}
    for name, value in figures.items():
        out.print(f"  {name:18} [{'red' if name in failed else 'bold'}]{value}[/]")
