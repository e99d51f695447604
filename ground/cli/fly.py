# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie goto`, `explore`, `fly`, `patrol`, `spin`, `home`, `land`, `stop`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from ground.checks import Files
from ground.cli.parts import FLY, JsonFile, Record, Uri, finite, numbers, out, run
from ground.link.uri import SIMULATOR_URI

if TYPE_CHECKING:
    from ground.model import Point

MINUS = {"ignore_unknown_options": True}  # -1,2 is a place, not an option

flights = typer.Typer(rich_markup_mode="markdown")

Points = Annotated[
    list[str],
    typer.Argument(metavar="X,Y...", help="Metres ahead and to the left of the take-off place."),
]


@flights.command(rich_help_panel=FLY, context_settings=MINUS)
def goto(
    x: Annotated[
        float,
        typer.Argument(metavar="X", callback=finite, help="Metres ahead of the take-off place."),
    ],
    y: Annotated[
        float, typer.Argument(metavar="Y", callback=finite, help="Metres to the left of it.")
    ],
    uri: Uri = SIMULATOR_URI,
    hold: Annotated[
        bool, typer.Option("--hold", help="Hover there until Ctrl-C instead of landing.")
    ] = False,
    json_file: JsonFile = None,
    record: Record = None,
) -> None:
    """Fly to a point and land there."""
    from ground.cli.commands import fly_to

    run(fly_to(uri, x, y, hold, Files(json_file, record), out))


@flights.command(rich_help_panel=FLY)
def explore(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None) -> None:
    """Map everything that can be reached, come back and land."""
    _mission("EXPLORE", uri, Files(json_file, record))


@flights.command(rich_help_panel=FLY, context_settings=MINUS)
def fly(
    points: Points, uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None
) -> None:
    """Fly along points, and land at the last."""
    _along("FLY", points, uri, Files(json_file, record))


@flights.command(rich_help_panel=FLY, context_settings=MINUS)
def patrol(
    points: Points, uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None
) -> None:
    """Fly along points again and again, until Ctrl-C or a low battery."""
    _along("PATROL", points, uri, Files(json_file, record))


@flights.command(rich_help_panel=FLY)
def spin(
    uri: Uri = SIMULATOR_URI,
    turns: Annotated[
        float,
        typer.Option(
            min=-20.0, max=20.0, metavar="N", help="How many turns; to the right if negative."
        ),
    ] = 1.0,
    json_file: JsonFile = None,
    record: Record = None,
) -> None:
    """Turn in place, for fun or to look around, and land."""
    from ground.cli.commands import spin_round

    run(spin_round(uri, turns, Files(json_file, record), out))


@flights.command(rich_help_panel=FLY)
def home(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None) -> None:
    """Fly back to the place of take-off and land."""
    _mission("HOME", uri, Files(json_file, record))


@flights.command(rich_help_panel=FLY)
def land(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None) -> None:
    """Land at the present place."""
    _mission("LAND", uri, Files(json_file, record))


@flights.command(rich_help_panel=FLY)
def stop(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None) -> None:
    """Emergency: stop the motors at once. The drone falls and stays locked until restarted."""
    from ground.cli.commands import emergency_stop

    run(emergency_stop(uri, json_file, out))


def _mission(name: str, uri: str, files: Files) -> None:
    from ground.cli.commands import fly_mission
    from ground.core import MissionCmd

    run(fly_mission(uri, MissionCmd[name], files, out))


def _along(name: str, points: list[str], uri: str, files: Files) -> None:
    from ground.cli.commands import fly_along
    from ground.core import MissionCmd

    run(fly_along(uri, MissionCmd[name], _points(points), files, out))


def _points(words: list[str]) -> list[Point]:
    from ground.model import Point

    return [Point(*numbers(word, "X,Y in metres", 2)) for word in words]
