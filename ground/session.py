# SPDX-License-Identifier: GPL-3.0-or-later
"""What the commands share: say what happens, land on Ctrl-C, serve the page for a link."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import time
from collections.abc import AsyncIterator
from pathlib import Path

from rich.console import Console

from ground.core import EventCode, MissionCmd, MissionReason, MissionState
from ground.errors import GroundError
from ground.flight import Outcome, fly
from ground.link_kept import KeptLink
from ground.link_radio import RadioLink
from ground.model import Event, LinkChange, LinkState, Point
from ground.record import not_taken, recorded, where_told
from ground.station import Station, station_on
from ground.web.fleet import Member
from ground.words import EXPLORED, EXPLORED_PARTLY, REASON_WORDS, STATE_WORDS

log = logging.getLogger(__name__)

RETRY_S = 0.5
LANDING_S = 60.0
SETTLING_S = 15.0
READY_S = 3.0
SETTLING_RETRY_S = 0.2


@contextlib.asynccontextmanager
async def narrated(station: Station, console: Console, name: str = "") -> AsyncIterator[None]:
    """Say what the drone does meanwhile, a line for each change, each beginning with a name."""
    task = asyncio.create_task(_narrate(station, console, name))
    try:
        yield
    finally:
        task.cancel()


async def _narrate(station: Station, console: Console, name: str) -> None:
    with contextlib.suppress(GroundError), station.listen(Event) as listener:
        while True:
            match await listener.next():
                case Event() as event if words := _words(event):
                    console.print(f"[dim]{name}{event.drone_ms / 1000:8.1f} s[/]  {words}")
                case LinkChange(state, detail):
                    colour = "green" if state is LinkState.CONNECTED else "yellow"
                    console.print(f"[{colour}]{name}link: {detail}[/]")


def now(station: Station) -> str:
    """How things are, in one line."""
    picture = station.picture
    area_m2 = picture.map.known_cells * picture.map.cell_m**2
    words = [STATE_WORDS[picture.state], f"{area_m2:.1f} m² known"]
    if picture.health:
        words.append(f"{picture.health.battery_v:.2f} V")
    return "  ".join([*words, f"{picture.drone_ms / 1000:.0f} s", "Ctrl-C lands"])


def _words(event: Event) -> str:
    """What is said of an event; nothing of most."""
    match event.code:
        case EventCode.STATE:
            return STATE_WORDS[MissionState(event.argument)]
        case EventCode.FAULT:
            return f"[red]{REASON_WORDS[event.reason]}[/]"
        case EventCode.EXPLORED if event.argument:
            return f"[yellow]{EXPLORED_PARTLY}[/]"
        case EventCode.EXPLORED:
            return EXPLORED
        case EventCode.WAYPOINT:
            return f"at way point {event.argument + 1}"
        case EventCode.SKIPPED:
            place = f"({event.place.x_m:.2f}, {event.place.y_m:.2f})"
            return f"[yellow]way point {place} left out: {REASON_WORDS[event.reason]}[/]"
    return ""


@contextlib.asynccontextmanager
async def landing_on_interrupt(station: Station, console: Console) -> AsyncIterator[None]:
    """Ctrl-C cancels the program's task: land before it ends. A second Ctrl-C ends it at once."""
    try:
        yield
    except asyncio.CancelledError:
        if station.picture.state.airborne:
            console.print("landing first (Ctrl-C again: leave at once)")
            with contextlib.suppress(GroundError):
                async with asyncio.timeout(LANDING_S):
                    await fly(station, MissionCmd.LAND)
        raise


async def fly_when_settled(
    station: Station, cmd: MissionCmd, goal: Point | None, console: Console
) -> Outcome:
    """As fly(), but give the position estimate some time after the drone was switched on, and the
    supervisor after a landing."""
    begin_s = time.monotonic()
    told = False
    while True:
        outcome = await fly(station, cmd, goal)
        if time.monotonic() - begin_s > _patience_s(station, outcome):
            return outcome
        if not told:
            console.print("waiting until it is ready to fly")
            told = True
        await asyncio.sleep(SETTLING_RETRY_S)


def _patience_s(station: Station, outcome: Outcome) -> float:
    """So long a refusal may pass by itself; negative if it does not."""
    health, state = station.picture.health, station.picture.state
    if not state.airborne and outcome.reason is MissionReason.ESTIMATOR:
        return SETTLING_S
    locked = health is None or health.locked or health.tumbled
    if not state.airborne and outcome.reason is MissionReason.CANNOT_FLY and not locked:
        return READY_S
    return -1.0


def explain(outcome: Outcome) -> str:
    """How it ended, in one line."""
    place = outcome.place
    if outcome.reached or place is None:
        return outcome.sentence
    nearest = f"({place.x_m:.2f}, {place.y_m:.2f})"
    return f"{outcome.sentence}; the nearest point that can be reached is {nearest}"


async def keep_connected(
    member: Member, named: bool, record: Path | None, console: Console
) -> None:
    """Give the cockpit a station for as long as there is a drone; look for one again and again."""
    cockpit, uri, told = member.cockpit, member.name, ""
    name = f"{uri}  " if named else ""
    while True:
        try:
            file = not_taken(record) if record else None
            link = recorded(KeptLink(lambda: RadioLink(uri)), file)
            async with station_on(link) as station, where_told(link, console):
                console.print(f"connected to {uri}")
                told, cockpit.station = "", station
                async with (
                    narrated(station, console, name),
                    landing_on_interrupt(station, console),
                ):
                    await station.ended()
        except GroundError as error:
            cockpit.trouble = str(error)
            if str(error) != told:
                told = str(error)
                console.print(f"[yellow]{told}[/]")
        finally:
            cockpit.station = None
        await asyncio.sleep(RETRY_S)
