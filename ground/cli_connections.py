# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie ground`, `wayflie scan`, `wayflie doctor`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ground.checks import write_json
from ground.cli_parts import (
    CONNECT,
    SIMULATOR_URI,
    START,
    JsonFile,
    Port,
    Record,
    Uri,
    end,
    finish,
    out,
    run,
)
from ground.errors import GroundError, LinkUnavailable
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
        help="Which Crazyflie, once for each; the simulator's if not given. With the place where "
        "it was set down, in metres and degrees as the first sees it, they share a map.",
    ),
]


def members_of(uris: list[str]) -> list[Member]:
    """What the option --uri says."""
    from ground.web.cockpit import Cockpit
    from ground.web.fleet import Member, Place

    members = []
    for text in uris:
        uri, at, place = text.rpartition("@")
        if not at:
            members.append(Member(Cockpit(), text))
            continue
        try:
            x_m, y_m, yaw_deg = map(float, [*place.split(","), "0"][:3])
        except ValueError:
            raise typer.BadParameter(f"{place!r} is no X,Y or X,Y,YAW") from None
        if not all(map(math.isfinite, (x_m, y_m, yaw_deg))):
            raise typer.BadParameter(f"{place!r} is no place")
        members.append(Member(Cockpit(), uri, Place(x_m, y_m, math.radians(yaw_deg))))
    if len({member.name for member in members}) < len(members):
        raise typer.BadParameter("the same Crazyflie twice")
    return members


@connections.command(rich_help_panel=START)
def ground(
    uri: Uris = None,
    every: Annotated[bool, typer.Option("--all", help="All that the scan finds.")] = False,
    port: Port = None,
    bind: Annotated[
        str,
        typer.Option(
            help="Address to serve the page at; others than this machine's own ask "
            "for a token, which is printed."
        ),
    ] = "127.0.0.1",
    record: Record = None,
) -> None:
    """Serve the page for a drone, or several: map, state, and buttons to fly them."""
    from ground.commands import serve_ground

    try:
        found = [one for one in _scan() if not one.startswith("serial://")] if every else uri
    except GroundError as error:
        end(error)
    uris = found or [SIMULATOR_URI]
    run(serve_ground(members_of(uris), port, bind, record, out))


@connections.command(rich_help_panel=CONNECT)
def scan(json_file: JsonFile = None) -> None:
    """List the Crazyflies that answer, and the serial devices there are."""
    finish(lambda: _list(json_file))


@connections.command(rich_help_panel=CONNECT)
def doctor(
    uri: Uri = SIMULATOR_URI,
    seconds: Annotated[
        float, typer.Option(min=1.0, max=600.0, metavar="S", help="To listen.")
    ] = 5.0,
    json_file: JsonFile = None,
) -> None:
    """Look for what is missing: drivers, permissions, decks, app, link, battery."""
    from ground.doctor import examine

    run(examine(uri, seconds, json_file, out))


def _list(json_file: Path | None) -> bool:
    found = _scan()
    for uri in found:
        out.print(uri)
    if json_file:
        write_json(json_file, {"found": found})
    if not found:
        raise LinkUnavailable("nothing found", "`wayflie doctor` says what may be missing")
    return True


def _scan() -> list[str]:
    from ground.link_drivers import scan

    with waiting(out, "listening on every radio channel, USB and UDP port"):
        return scan()
