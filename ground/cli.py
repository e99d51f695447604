# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `wayflie`. Heavy modules are imported by the command that needs them."""

from __future__ import annotations

import logging
from typing import Annotated

import typer
from rich.logging import RichHandler

from ground import __version__
from ground.cli_bench import bench_app
from ground.cli_campaign import campaigns
from ground.cli_connections import connections
from ground.cli_fly import flights
from ground.cli_map import map_app
from ground.cli_parts import EXITS, FILES, MEASURE, end, err, out
from ground.cli_records import records
from ground.cli_start import Commands, start, welcome
from ground.errors import GroundError

app = typer.Typer(
    name="wayflie",
    cls=Commands,
    help="Lets a Crazyflie map, plan and fly its own way through an unknown room.",
    epilog=f"`wayflie` alone shows what to try first; `wayflie COMMAND --help` tells more. {EXITS}",
    rich_markup_mode="markdown",
    invoke_without_command=True,
)
app.add_typer(start)
app.add_typer(connections)
app.add_typer(flights)
app.add_typer(map_app, name="map", rich_help_panel=FILES)
app.add_typer(records)
app.add_typer(campaigns)
app.add_typer(bench_app, name="bench", rich_help_panel=MEASURE)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"wayflie {__version__}")
        raise typer.Exit


@app.callback()
def settings(
    ctx: typer.Context,
    verbose: Annotated[
        int,
        typer.Option(
            "--verbose",
            "-v",
            count=True,
            metavar="",
            show_default=False,
            help="Say more; twice: everything.",
        ),
    ] = 0,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Set up what all commands share."""
    out.stderr = False
    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbose, 2)]
    handler = RichHandler(console=err, show_path=False)
    logging.basicConfig(level=level, format="%(message)s", handlers=[handler])
    if verbose < 2:  # cflib reports what is normal here (no writable cache, a closed socket)
        logging.getLogger("cflib").setLevel(logging.CRITICAL)
    if ctx.invoked_subcommand is None:
        welcome(out)


def main() -> None:
    """Entry point."""
    try:
        app(prog_name="wayflie")
    except GroundError as error:  # raised while a command's modules were imported
        end(error)
