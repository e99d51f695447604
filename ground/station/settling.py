# SPDX-License-Identifier: GPL-3.0-or-later
"""Repeats commands that a drone just switched on or just landed may refuse for a moment."""

from __future__ import annotations

import asyncio
import contextlib
import time
from collections.abc import Callable

from ground.core import MissionCmd, MissionReason
from ground.model import Point
from ground.station.flight import Outcome, fly
from ground.station.station import Station

SETTLING_S = 15.0
READY_S = 3.0
BEGINNING_S = 5.0
SETTLING_RETRY_S = 0.2


async def fly_when_settled(
    station: Station,
    cmd: MissionCmd,
    goal: Point | None = None,
    tell: Callable[[str], object] | None = None,
) -> Outcome:
    """Like fly(), repeated while a refusal may pass by itself; `tell` gets a line while it waits.

    The position estimate settles after power-on, the supervisor after a landing.
    """
    await _begun(station)
    begin_s, begin_ms = time.monotonic(), station.picture.drone_ms
    told = False
    while True:
        outcome = await fly(station, cmd, goal)
        drone_s = (station.picture.drone_ms - begin_ms) / 1000
        waited_s = min(drone_s, time.monotonic() - begin_s)
        if waited_s > _patience_s(station, outcome):
            return outcome
        if tell and not told:
            tell("waiting until it is ready to fly")
            told = True
        await asyncio.sleep(SETTLING_RETRY_S)


async def _begun(station: Station) -> None:
    """Wait until the first log packets have come, so that a recording has the flight's beginning.

    A drone that does not send all of them is waited for no longer than BEGINNING_S.
    """
    with contextlib.suppress(TimeoutError), station.listen() as listener:
        async with asyncio.timeout(BEGINNING_S):
            while not station.picture.begun:
                await listener.next()


def _patience_s(station: Station, outcome: Outcome) -> float:
    """How long this refusal may take to pass by itself; negative if it will not."""
    health, state = station.picture.health, station.picture.state
    if not state.airborne and outcome.reason is MissionReason.ESTIMATOR:
        return SETTLING_S
    locked = health is not None and (health.locked or health.tumbled)
    if not state.airborne and outcome.reason is MissionReason.CANNOT_FLY and not locked:
        return READY_S
    return -1.0
