# SPDX-License-Identifier: GPL-3.0-or-later
"""Transfers maps from and to the drone, which relocalises by itself in a map that was sent."""

from __future__ import annotations

import asyncio
import contextlib

import numpy as np

from ground.core import TILE_SIDE_CELLS, TILES, TILES_PER_ROW, MissionCmd, MissionReason
from ground.errors import GroundError, NoAnswer
from ground.map.groundmap import GroundMap
from ground.model import Hello
from ground.station.station import Station
from ground.words import refusal

PATIENCE_S = 30.0
ROUNDS = 6
PACE_S = 0.01  # between two tiles: the drone takes ten per tick, and its queue holds ten
QUIET_S = 1.0  # without a change of the echoed map, missing tiles count as lost
SAME_M = 1e-3


async def await_map(station: Station) -> bool:
    """Wait until the whole map has come down. @return False if some of it did not"""
    station.ask_snapshot()
    with contextlib.suppress(TimeoutError):
        async with asyncio.timeout(PATIENCE_S):
            while station.picture.map.completeness < 1:
                await asyncio.sleep(0.05)
    return station.picture.map.completeness == 1


async def send_map(station: Station, kept: GroundMap) -> None:
    """Replace the map of a drone on the ground; done when the drone has sent the same map back.

    Raises CommandRefused in the air, GroundError if the grids differ, NoAnswer.
    """
    hello = await forget_map(station)
    _check_grid(kept, station.picture.map)
    for _ in range(ROUNDS):
        missing = _missing(kept, station.picture.map)
        if not missing:
            return
        for tile in missing:
            station.send(kept.piece(tile, hello.epoch))
            await asyncio.sleep(PACE_S)
        await _echo(station, kept)
    if missing := _missing(kept, station.picture.map):
        raise NoAnswer(f"{len(missing)} of {TILES} tiles of the map did not arrive")


async def forget_map(station: Station) -> Hello:
    """Make a drone on the ground start a new map, and return its grid."""
    if station.picture.state.airborne:
        raise refusal(MissionReason.FLYING)
    await station.command(MissionCmd.FORGET)
    return await station.greet()


def _check_grid(kept: GroundMap, drone: GroundMap) -> None:
    apart_m = max(
        abs(kept.origin.x_m - drone.origin.x_m),
        abs(kept.origin.y_m - drone.origin.y_m),
        abs(kept.cell_m - drone.cell_m),
    )
    if apart_m > SAME_M:
        raise GroundError(
            f"the map's cells of {kept.cell_m:.3f} m from ({kept.origin.x_m:.2f}, "
            f"{kept.origin.y_m:.2f}) do not fit the drone's of {drone.cell_m:.3f} m from "
            f"({drone.origin.x_m:.2f}, {drone.origin.y_m:.2f}): set way.cell and the area first"
        )


def _missing(kept: GroundMap, drone: GroundMap) -> list[int]:
    """Tiles in which the drone's map differs from the kept one."""
    shape = (TILES_PER_ROW, TILE_SIDE_CELLS, TILES_PER_ROW, TILE_SIDE_CELLS)
    differs = (kept.states != drone.states).reshape(shape).any(axis=(1, 3))
    return [int(tile) for tile in np.flatnonzero(differs)]


def alike(kept: GroundMap, drone: GroundMap) -> float:
    """Share of tiles in which the drone's map equals the kept one."""
    return 1 - len(_missing(kept, drone)) / TILES


async def _echo(station: Station, kept: GroundMap) -> None:
    """Wait until the drone's map equals the kept one, or has stopped changing."""
    loop = asyncio.get_running_loop()
    until_s, revision = loop.time() + QUIET_S, station.picture.map.revision
    while loop.time() < until_s and _missing(kept, station.picture.map):
        if station.picture.map.revision != revision:
            revision = station.picture.map.revision
            until_s = loop.time() + QUIET_S
        await asyncio.sleep(0.05)
