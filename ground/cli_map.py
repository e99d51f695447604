# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie map`: the drone's map to files and back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ground.cli_parts import SIMULATOR_URI, JsonFile, Uri, end, finish, out, run
from ground.errors import GroundError

if TYPE_CHECKING:
    from ground.model import Pose

map_app = typer.Typer(
    help="The map that the drone has made: save it, load it.", no_args_is_help=True
)

Force = Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")]


def _parse_pose(text: str) -> Pose:
    from ground.model import Pose

    try:
        x_m, y_m, yaw_rad = (float(number) for number in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{text!r} is no X,Y,YAW in metres and radians") from None
    return Pose(x_m, y_m, 0.0, yaw_rad)


@map_app.command("save")
def save(
    file: Annotated[
        Path,
        typer.Argument(
            help="room.yaml (with room.pgm, for ROS map_server), .png, .svg, .csv of the "
            "obstacles, or .npz, which can be loaded with all its points."
        ),
    ],
    uri: Uri = SIMULATOR_URI,
    recording: Annotated[
        Path | None,
        typer.Option("--from", help="The map at the end of this recording, not the drone's."),
    ] = None,
    poses: Annotated[
        Path | None, typer.Option(help="With --from: a .csv for the poses of the flight.")
    ] = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Fetch the whole map from the drone, or from a recording, and write it to a file."""
    from ground.mapfile import check_free

    if poses and not recording:
        raise typer.BadParameter("--poses goes with --from")
    try:
        check_free([file, *([poses] if poses else [])], force)
    except GroundError as error:
        end(error)
    if recording:
        from ground.export import export_recording

        finish(lambda: export_recording(recording, file, poses, json_file, out))
        return
    from ground.commands import fetch_map

    run(fetch_map(uri, file, json_file, out))


@map_app.command("load")
def load(
    file: Annotated[
        Path,
        typer.Argument(help="The .yaml of a ROS map, or what `wayflie map save` wrote as .npz."),
    ],
    uri: Uri = SIMULATOR_URI,
    pose: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,YAW",
            help="Where in it the drone stands, in metres and radians: the map is laid so that "
            "this becomes the drone's origin.",
        ),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Give the drone, on the ground, a map to find itself in."""
    from ground.commands import give_map

    run(give_map(uri, file, _parse_pose(pose) if pose else None, json_file, out))
