# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of flight commands: narration, landing on Ctrl-C, a page that stays connected."""

from __future__ import annotations

import asyncio
import contextlib
import logging
from collections.abc import AsyncIterator
from pathlib import Path

from rich.console import Console

from ground.core import EventCode
from ground.errors import GroundError
from ground.link.kept import KeptLink
from ground.link.radio import RadioLink
from ground.model import Event, LinkChange, LinkState
from ground.nextsteps import next_step
from ground.record.recorder import not_taken, recorded, where_told
from ground.station.flight import bring_down
from ground.station.station import Station, station_on
from ground.web.fleet import Member
from ground.words import STATE_WORDS, Level, event_words

log = logging.getLogger(__name__)

RETRY_S = 0.5
COLOURS: dict[Level, str] = {"info": "none", "good": "green", "warning": "yellow", "error": "red"}
_TOLD_BY_OUTCOME = (EventCode.REFUSED, EventCode.ARRIVED)


@contextlib.asynccontextmanager
async def narrated(station: Station, console: Console, name: str = "") -> AsyncIterator[None]:
    """Print a line for each event and link change meanwhile; `name` is put before each."""
    task = asyncio.create_task(_narrate(station, console, name))
    try:
        yield
    finally:
        task.cancel()


async def _narrate(station: Station, console: Console, name: str) -> None:
    with contextlib.suppress(GroundError), station.listen(Event) as listener:
        while True:
            match await listener.next():
                case Event() as event if event.code not in _TOLD_BY_OUTCOME:
                    words, level = event_words(event)
                    time = f"[dim]{name}{event.drone_ms / 1000:8.1f} s[/]"
                    console.print(f"{time}  [{COLOURS[level]}]{words}[/]")
                case LinkChange(state, detail):
                    colour = "green" if state is LinkState.CONNECTED else "yellow"
                    console.print(f"[{colour}]{name}link: {detail}[/]")


def now(station: Station) -> str:
    """The present state in one line."""
    picture = station.picture
    area_m2 = picture.map.known_cells * picture.map.cell_m**2
    words = [STATE_WORDS[picture.state], f"{area_m2:.1f} m² known"]
    if picture.health:
        words.append(f"{picture.health.battery_v:.2f} V")
    return "  ".join([*words, f"{picture.drone_ms / 1000:.0f} s", "Ctrl-C lands"])


@contextlib.asynccontextmanager
async def landing_on_interrupt(station: Station, console: Console) -> AsyncIterator[None]:
    """On Ctrl-C (which cancels the task) land before ending; a second Ctrl-C ends at once."""
    try:
        yield
    except asyncio.CancelledError:
        if station.picture.state.airborne:
            console.print("landing first (Ctrl-C again: leave at once)")
            await bring_down(station)
        raise


async def keep_connected(
    member: Member, named: bool, record: Path | None, console: Console
) -> None:
    """Keep the cockpit's station connected to its drone; retry for ever."""
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
            cockpit.trouble = error
            if str(error) != told:
                told, step = str(error), next_step(error)
                console.print(f"[yellow]{told}[/]")
                if step:
                    console.print(f"  next: {step}", markup=False)
        finally:
            cockpit.station = None
        await asyncio.sleep(RETRY_S)
