# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie replay`, `wayflie plot`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ground.cli.parts import FILES, JsonFile, Port, finish, in_folder, out, run

records = typer.Typer(rich_markup_mode="markdown")

File = Annotated[
    Path | None, typer.Argument(help="A recording of a flight; if not given, your newest.")
]


def _chosen(file: Path | None) -> Path:
    from ground.record.folder import newest_recording

    return file or newest_recording()


@records.command(rich_help_panel=FILES)
def replay(
    file: File = None,
    speed: Annotated[
        float, typer.Option(min=0.1, max=1000.0, metavar="N", help="Speed; 2 is twice as fast.")
    ] = 1.0,
    port: Port = None,
    rerun: Annotated[
        bool,
        typer.Option(
            "--rerun", help="Without the page: run the C code again on the recorded sensor data."
        ),
    ] = False,
    into: Annotated[
        Path | None,
        typer.Option(
            "--into", callback=in_folder, help="With --rerun: record what the C code says now."
        ),
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Show a recorded flight on the page again, with a timeline; or compute it again.

    With --rerun, a recording of `wayflie sim --record-inputs` must give the same bits, else the
    exit code is 1. A recording made over a radio holds only what came through: the flight is
    computed from that and compared with what the drone said.
    """
    if rerun:
        from ground.sim.rerun import rerun_file

        chosen = _chosen(file)
        finish(lambda: rerun_file(chosen, into, json_file, out))
        return
    if into or json_file:
        raise typer.BadParameter("--into and --json go with --rerun")
    from ground.cli.replay import replay_flight

    run(replay_flight(_chosen(file), speed, port, out))


@records.command(rich_help_panel=FILES)
def plot(
    file: File = None,
    image: Annotated[
        Path | None,
        typer.Option(
            "--image",
            "-o",
            callback=in_folder,
            help="A .png, .svg or .pdf; if not given, FILE with the ending .png.",
        ),
    ] = None,
    world: Annotated[
        str, typer.Option(help="The simulated world of the flight: a name, or a TOML file.")
    ] = "",
    truth: Annotated[
        Path | None, typer.Option(help="What `wayflie sim --trail --json FILE` wrote about it.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite a file that exists.")] = False,
) -> None:
    """Draw a recorded flight: map, paths, errors, the planner's times."""
    from ground.record.plot import plot_flight
    from ground.sim.truth import read_truth

    chosen = _chosen(file)

    def work() -> bool:
        known = read_truth(world, truth) if world or truth else None
        return plot_flight(chosen, image or chosen.with_suffix(".png"), known, force, out)

    finish(work)
