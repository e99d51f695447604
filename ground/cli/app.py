# SPDX-License-Identifier: GPL-3.0-or-later
"""Assembles the command `wayflie`; each command imports its heavy modules itself."""

from __future__ import annotations

import logging
from typing import Annotated

import typer
from rich.logging import RichHandler

from ground import __version__
from ground.cli.bench import bench_app
from ground.cli.campaign import campaigns
from ground.cli.connections import connections
from ground.cli.fly import flights
from ground.cli.map import map_app
from ground.cli.parts import EXITS, FILES, MEASURE, err, out
from ground.cli.records import records
from ground.cli.start import Commands, start, welcome

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
            help="Print more; -vv prints everything.",
        ),
    ] = 0,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Set up logging; without a command, show what to try first."""
    out.stderr = False
    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbose, 2)]
    handler = RichHandler(console=err, show_path=False)
    logging.basicConfig(level=level, format="%(message)s", handlers=[handler])
    if verbose < 2:  # cflib warns of what is normal here (no writable cache, a closed socket)
        logging.getLogger("cflib").setLevel(logging.CRITICAL)
    if ctx.invoked_subcommand is None:
        welcome(out)


def main() -> None:
    """Entry point of the command `wayflie`."""
    app(prog_name="wayflie")
