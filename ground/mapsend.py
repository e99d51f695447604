# SPDX-License-Identifier: GPL-3.0-or-later
"""Give the drone a map that was kept. It then finds out by itself where in it it is."""

from __future__ import annotations

import asyncio

import numpy as np

from ground.core import TILE_SIDE_CELLS, TILES, TILES_PER_ROW, MissionCmd, MissionReason
from ground.errors import GroundError, NoAnswer
from ground.map import GroundMap
from ground.model import Hello
from ground.station import Station
from ground.words import refusal

ROUNDS = 6
PACE_S = 0.01  # between two pieces: the drone takes ten a tick, and its queue holds ten
QUIET_S = 1.0  # without a change of the map: what is missing was lost
SAME_M = 1e-3


async def send_map(station: Station, kept: GroundMap) -> None:
    """Replace the drone's map, on the ground; done when the same map has come back.

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
    """Let the drone begin a new map, on the ground; from then on its grid is known."""
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
    """Tiles in which the drone's map is not the one that was kept."""
    shape = (TILES_PER_ROW, TILE_SIDE_CELLS, TILES_PER_ROW, TILE_SIDE_CELLS)
    differs = (kept.states != drone.states).reshape(shape).any(axis=(1, 3))
    return [int(tile) for tile in np.flatnonzero(differs)]


def alike(kept: GroundMap, drone: GroundMap) -> float:
    """Share of the tiles in which the drone's map is the one that was kept."""
    return 1 - len(_missing(kept, drone)) / TILES


async def _echo(station: Station, kept: GroundMap) -> None:
    """Wait until the drone's map is the one that was sent, or no more of it comes."""
    loop = asyncio.get_running_loop()
    until_s, revision = loop.time() + QUIET_S, station.picture.map.revision
    while loop.time() < until_s and _missing(kept, station.picture.map):
        if station.picture.map.revision != revision:
            revision = station.picture.map.revision
            until_s = loop.time() + QUIET_S
        await asyncio.sleep(0.05)
