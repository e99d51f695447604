# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie map`: the drone's map to files and back."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ground.cli.parts import JsonFile, Uri, finish, numbers, out, run
from ground.link.uri import SIMULATOR_URI

if TYPE_CHECKING:
    from ground.model import Pose

map_app = typer.Typer(
    help="The map that the drone has made: save it, load it.", no_args_is_help=True
)

Force = Annotated[bool, typer.Option("--force", help="Overwrite files that exist.")]


def _parse_pose(text: str) -> Pose:
    from ground.model import Pose

    x_m, y_m, yaw_rad = numbers(text, "X,Y,YAW in metres and radians", 3)
    return Pose(x_m, y_m, 0.0, yaw_rad)


@map_app.command("save")
def save(
    file: Annotated[
        Path,
        typer.Argument(
            help="room.yaml (with room.pgm, for ROS map_server), .png, .svg, .csv (the obstacles) "
            "or .npz, which `wayflie map load` reads back exactly."
        ),
    ],
    uri: Uri = SIMULATOR_URI,
    recording: Annotated[
        Path | None,
        typer.Option("--from", help="Take the map at the end of this recording instead."),
    ] = None,
    poses: Annotated[
        Path | None, typer.Option(help="With --from: also write the poses of the flight, as CSV.")
    ] = None,
    force: Force = False,
    json_file: JsonFile = None,
) -> None:
    """Fetch the whole map from the drone, or from a recording, and write it to a file."""
    from ground.map.files import check_file, check_free

    if poses and not recording:
        raise typer.BadParameter("--poses goes with --from")
    check_free(file, force)
    if poses:
        check_file(poses, force)
    if recording:
        from ground.record.export import export_recording

        finish(lambda: export_recording(recording, file, poses, json_file, out))
        return
    from ground.cli.commands import fetch_map

    run(fetch_map(uri, file, json_file, out))


@map_app.command("load")
def load(
    file: Annotated[
        Path,
        typer.Argument(help="The .yaml of a ROS map, or a .npz that `wayflie map save` wrote."),
    ],
    uri: Uri = SIMULATOR_URI,
    pose: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,YAW",
            help="Where the drone stands on a ROS map, in metres and radians: that becomes "
            "the origin of its map.",
        ),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Load a map into a drone that stands on the ground; it then finds its place in it."""
    from ground.cli.commands import give_map

    run(give_map(uri, file, _parse_pose(pose) if pose else None, json_file, out))
