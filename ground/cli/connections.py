# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie ground`, `wayflie scan`, `wayflie doctor`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ground.checks import write_json
from ground.cli.parts import (
    CONNECT,
    START,
    JsonFile,
    Port,
    Record,
    Uri,
    finish,
    numbers,
    out,
    run,
)
from ground.errors import LinkUnavailable
from ground.link.uri import SIMULATOR_URI
from ground.progress import waiting

if TYPE_CHECKING:
    from ground.web.fleet import Member

connections = typer.Typer()

Uris = Annotated[
    list[str] | None,
    typer.Option(
        "--uri",
        envvar="CFLIB_URI",
        metavar="URI[@X,Y[,YAW]]",
        help="The Crazyflie; if not given, the simulator. Repeat it for each further one, with "
        "the place where that one stands, in metres and degrees as the first sees it: then they "
        "share a map.",
    ),
]


def members_of(uris: list[str]) -> list[Member]:
    """Parse the values of --uri. Raises BadUri."""
    from ground.link.drivers import check_uri
    from ground.web.cockpit import Cockpit
    from ground.web.fleet import Member, Place

    members: list[Member] = []
    for text in uris:
        uri, at, place = text.rpartition("@")
        if not at:
            members.append(Member(Cockpit(), text))
            continue
        x_m, y_m, yaw_deg = [*numbers(place, "X,Y or X,Y,YAW", 2, 3), 0.0][:3]
        members.append(Member(Cockpit(), uri, Place(x_m, y_m, math.radians(yaw_deg))))
    for member in members:
        check_uri(member.name)
    if len({member.name for member in members}) < len(members):
        raise typer.BadParameter("the same Crazyflie is named twice")
    return members


@connections.command(rich_help_panel=START)
def ground(
    uri: Uris = None,
    every: Annotated[
        bool, typer.Option("--all", help="All Crazyflies that the scan finds.")
    ] = False,
    port: Port = None,
    bind: Annotated[
        str,
        typer.Option(
            help="Address to serve the page at. Any but this machine's own asks visitors for a "
            "token, which is printed."
        ),
    ] = "127.0.0.1",
    record: Record = None,
) -> None:
    """Serve the page for a drone, or several: map, state, and buttons to fly them."""
    from ground.cli.commands import serve_ground

    found = [one for one in _scan() if not one.startswith("serial://")] if every else uri
    run(serve_ground(members_of(found or [SIMULATOR_URI]), port, bind, record, out))


@connections.command(rich_help_panel=CONNECT)
def scan(json_file: JsonFile = None) -> None:
    """List the Crazyflies that answer, and the serial devices of this machine."""
    finish(lambda: _list(json_file))


@connections.command(rich_help_panel=CONNECT)
def doctor(
    uri: Uri = SIMULATOR_URI,
    seconds: Annotated[
        float, typer.Option(min=1.0, max=600.0, metavar="S", help="How long to listen.")
    ] = 5.0,
    json_file: JsonFile = None,
) -> None:
    """Look for what is missing: drivers, permissions, decks, app, link, battery."""
    from ground.cli.doctor import examine

    run(examine(uri, seconds, json_file, out))


def _list(json_file: Path | None) -> bool:
    found = _scan()
    for uri in found:
        silent = uri.startswith("serial://")
        out.print(f"{uri}   (a serial device, not tested)" if silent else uri)
    if json_file:
        write_json(json_file, {"found": found})
    if not found:
        raise LinkUnavailable("no Crazyflie found", "`wayflie doctor` says what may be missing")
    return True


def _scan() -> list[str]:
    from ground.link.drivers import scan

    with waiting(out, "listening on every radio channel, USB and UDP port"):
        return scan()
