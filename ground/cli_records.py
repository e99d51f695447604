# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie replay`, `wayflie plot`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ground.cli_parts import FILES, JsonFile, Port, end, out, run
from ground.errors import GroundError

records = typer.Typer(rich_markup_mode="markdown")

File = Annotated[
    Path | None, typer.Argument(help="A recording of a flight; the newest of yours if not given.")
]


def _chosen(file: Path | None) -> Path:
    from ground.recordfolder import newest_recording

    try:
        return file or newest_recording()
    except GroundError as error:
        end(error)


@records.command(rich_help_panel=FILES)
def replay(
    file: File = None,
    speed: Annotated[
        float, typer.Option(min=0.1, max=1000.0, metavar="N", help="Times as fast.")
    ] = 1.0,
    port: Port = None,
    rerun: Annotated[
        bool,
        typer.Option("--rerun", help="No page: feed the sensors through the C code again."),
    ] = False,
    into: Annotated[
        Path | None,
        typer.Option("--into", help="With --rerun: record what the C code says now."),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Show a recorded flight on the page again, with a time line, or compute it again.

    What `wayflie sim --record-inputs` wrote is computed again bit for bit, or it exits with 1.
    A recording made over a radio holds what came through: it is computed from that, and
    compared with what the drone said.
    """
    if rerun:
        from ground.sim.rerun import rerun_file

        run(rerun_file(_chosen(file), into, json_file, out))
        return
    if into or json_file:
        raise typer.BadParameter("--into and --json go with --rerun")
    from ground.replay import replay_flight

    run(replay_flight(_chosen(file), speed, port, out))


@records.command(rich_help_panel=FILES)
def plot(
    file: File = None,
    image: Annotated[
        Path | None, typer.Option("--image", "-o", help="A .png, .svg or .pdf; FILE.png else.")
    ] = None,
    world: Annotated[
        str, typer.Option(help="The simulated world that it was: a name, or a TOML file.")
    ] = "",
    truth: Annotated[
        Path | None, typer.Option(help="What `wayflie sim --trail --json` wrote of it.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite a file that exists.")] = False,
) -> None:
    """Draw a recorded flight: map, trajectories, errors, times of the planner."""
    from ground.plot import plot_flight
    from ground.sim.truth import read_truth

    known = read_truth(world, truth) if world or truth else None
    chosen = _chosen(file)
    run(plot_flight(chosen, image or chosen.with_suffix(".png"), known, force, out))
