# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie fly`, `wayflie patrol`, `wayflie spin`."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from typing import Annotated, Any

import typer

from ground.checks import Files
from ground.cli_parts import SIMULATOR_URI, JsonFile, Record, Uri, out
from ground.model import Point

Points = Annotated[
    list[str],
    typer.Argument(metavar="X,Y...", help="Metres forward and to the left of the take-off place."),
]
MINUS = {"ignore_unknown_options": True}  # -1,2 is a place


def _points(words: list[str]) -> list[Point]:
    points = []
    for word in words:
        try:
            x, y = (float(number) for number in word.split(","))
        except ValueError:
            raise typer.BadParameter(f"{word!r} is no X,Y in metres") from None
        points.append(Point(x, y))
    return points


def add_missions(app: typer.Typer, run: Callable[[Coroutine[Any, Any, bool]], None]) -> None:
    """Add the commands to the command line."""

    @app.command(context_settings=MINUS)
    def fly(
        points: Points, uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None
    ) -> None:
        """Fly along points, and land at the last."""
        from ground.commands import fly_along
        from ground.core import MissionCmd

        files = Files(json_file, record)
        run(fly_along(uri, MissionCmd.FLY, _points(points), files, out))

    @app.command(context_settings=MINUS)
    def patrol(
        points: Points, uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None
    ) -> None:
        """Fly along points again and again, until Ctrl-C or a low battery."""
        from ground.commands import fly_along
        from ground.core import MissionCmd

        files = Files(json_file, record)
        run(fly_along(uri, MissionCmd.PATROL, _points(points), files, out))

    @app.command()
    def spin(
        uri: Uri = SIMULATOR_URI,
        turns: Annotated[
            float, typer.Option(min=-20.0, max=20.0, help="How often; to the right if negative.")
        ] = 1.0,
        json_file: JsonFile = None,
        record: Record = None,
    ) -> None:
        """Turn in place, for fun and to look around, and land."""
        from ground.commands import spin_round

        run(spin_round(uri, turns, Files(json_file, record), out))
