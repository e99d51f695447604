# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie ground`, `wayflie scan`, `wayflie doctor`."""

from __future__ import annotations

import math
from collections.abc import Callable, Coroutine
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ground.cli_parts import SIMULATOR_URI, JsonFile, Port, Record, fail, out
from ground.errors import GroundError

if TYPE_CHECKING:
    from ground.web.fleet import Member

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


def add_connections(app: typer.Typer, run: Callable[[Coroutine[Any, Any, bool]], None]) -> None:
    """Add the commands to the command line."""

    @app.command()
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

        found = [one for one in _scan() if not one.startswith("serial://")] if every else uri
        uris = found or [SIMULATOR_URI]
        run(serve_ground(members_of(uris), port, bind, record, out))

    @app.command()
    def scan() -> None:
        """List the Crazyflies that answer, and the serial devices there are."""
        found = _scan()
        for uri in found:
            out.print(uri)
        if not found:
            fail("nothing found; `wayflie doctor` says what may be missing")

    @app.command()
    def doctor(
        uri: Annotated[
            str, typer.Option(envvar="CFLIB_URI", help="Which Crazyflie to look at.")
        ] = SIMULATOR_URI,
        seconds: Annotated[float, typer.Option(min=1.0, max=600.0, help="To listen.")] = 5.0,
        json_file: JsonFile = None,
    ) -> None:
        """Look for what is missing: drivers, permissions, decks, app, link, battery."""
        from ground.doctor import examine

        run(examine(uri, seconds, json_file, out))


def _scan() -> list[str]:
    from ground.link_drivers import scan

    try:
        return scan()
    except GroundError as error:
        fail(str(error))
