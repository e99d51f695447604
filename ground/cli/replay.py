# SPDX-License-Identifier: GPL-3.0-or-later
"""Shows a recording on the page."""

from __future__ import annotations

import asyncio
from pathlib import Path

from rich.console import Console

from ground.cli.session import narrated
from ground.record.replay import ReplayLink
from ground.station.picture import Picture
from ground.station.station import station_on
from ground.web.cockpit import Cockpit
from ground.web.fleet import Fleet
from ground.web.server import page_server


async def replay_flight(file: Path, speed: float, port: int | None, out: Console) -> bool:
    """Replay a recording on the page, until Ctrl-C."""
    link = ReplayLink(file, speed)
    async with station_on(link) as station, narrated(station, out):
        cockpit = Cockpit(station)
        cockpit.timeline = link

        def forget() -> None:
            station.picture = Picture()

        link.on_rewind = forget
        async with page_server(Fleet.of(cockpit), port) as address:
            out.print(f"page: [bold]{address}[/]   recording: {file}   (Ctrl-C ends)")
            await link.finished()
            out.print("the recording has ended; the page stays until Ctrl-C")
            await asyncio.Event().wait()
    return True
