# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `wayflie`. Heavy modules are imported by the command that needs them."""

from __future__ import annotations

import asyncio
import logging
import signal
import sys
from collections.abc import Coroutine
from typing import Annotated, Any

import typer
from rich.logging import RichHandler

from ground import __version__
from ground.checks import Files
from ground.cli_bench import bench_app
from ground.cli_campaign import campaign
from ground.cli_connections import add_connections
from ground.cli_map import map_app
from ground.cli_missions import add_missions
from ground.cli_parts import (
    EXIT_INTERRUPTED,
    SIMULATOR_URI,
    JsonFile,
    Port,
    Record,
    Uri,
    err,
    fail,
    out,
)
from ground.cli_records import add_records
from ground.errors import GroundError

app = typer.Typer(
    name="wayflie",
    help="Lets a Crazyflie map, plan and fly its own way through an unknown room.",
    epilog="Try first: [bold]wayflie demo[/]. Then, in two terminals: [bold]wayflie sim[/] and "
    "[bold]wayflie goto 2.0 1.0[/], or [bold]wayflie ground[/] for the page.",
    rich_markup_mode="rich",
    no_args_is_help=True,
    add_completion=False,
)
app.add_typer(map_app, name="map")
app.add_typer(bench_app, name="bench")
app.command()(campaign)


def _run(work: Coroutine[Any, Any, bool]) -> None:
    """Run to the end. Exit 0 if it reached what was asked, 1 if not, 130 after Ctrl-C."""
    # Being asked to end is as Ctrl-C: land first.
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    try:
        reached = asyncio.run(work)
    except GroundError as error:
        fail(str(error))
    except KeyboardInterrupt:
        raise typer.Exit(EXIT_INTERRUPTED) from None
    if not reached:
        raise typer.Exit(1)


def _version(wanted: bool) -> None:
    if wanted:
        print(f"wayflie {__version__}")
        raise typer.Exit


@app.callback()
def settings(
    verbose: Annotated[
        int, typer.Option("--verbose", "-v", count=True, help="Say more; twice: everything.")
    ] = 0,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Set up what all commands share."""
    level = (logging.WARNING, logging.INFO, logging.DEBUG)[min(verbose, 2)]
    handler = RichHandler(console=err, show_path=False)
    logging.basicConfig(level=level, format="%(message)s", handlers=[handler])
    if verbose < 2:  # cflib reports what is normal here (no writable cache, a closed socket)
        logging.getLogger("cflib").setLevel(logging.CRITICAL)


@app.command()
def demo(
    world: Annotated[str, typer.Option(help="Name of a world, or a TOML file.")] = "flat",
    headless: Annotated[
        bool, typer.Option("--headless", help="No page, as fast as it goes, ends by itself.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Same seed, same room and noise.")] = 1,
    port: Port = None,
    json_file: JsonFile = None,
    record: Record = None,
) -> None:
    """Fly a simulated Crazyflie through a flat that it has never seen, and watch it."""
    from ground.demo import DemoOptions, run_demo

    _run(run_demo(DemoOptions(world, headless, seed, port, json_file, record), out))


@app.command(
    add_help_option=False,
    context_settings={"allow_extra_args": True, "ignore_unknown_options": True},
)
def sim(ctx: typer.Context) -> None:
    """Simulate a Crazyflie behind a UDP port (`wayflie sim --help` shows its options)."""
    from ground.sim.command import sim as simulate

    simulator = typer.Typer(add_completion=False)
    simulator.command()(simulate)
    simulator(args=ctx.args, prog_name="wayflie sim")


add_connections(app, _run)
add_records(app, _run)


@app.command(context_settings={"ignore_unknown_options": True})
def goto(
    x: Annotated[float, typer.Argument(help="Metres forward of the take-off place.")],
    y: Annotated[float, typer.Argument(help="Metres to the left of it.")],
    uri: Uri = SIMULATOR_URI,
    hold: Annotated[
        bool, typer.Option("--hold", help="Hover there until Ctrl-C instead of landing.")
    ] = False,
    json_file: JsonFile = None,
    record: Record = None,
) -> None:
    """Fly to a point and land there."""
    from ground.commands import fly_to

    _run(fly_to(uri, x, y, hold, Files(json_file, record), out))


@app.command()
def explore(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None) -> None:
    """Map everything that can be reached, come back and land."""
    _mission("EXPLORE", uri, Files(json_file, record))


add_missions(app, _run)


@app.command()
def home(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None) -> None:
    """Fly back to where it took off, and land."""
    _mission("HOME", uri, Files(json_file, record))


@app.command()
def land(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None, record: Record = None) -> None:
    """Land where it is."""
    _mission("LAND", uri, Files(json_file, record))


def _mission(name: str, uri: str, files: Files) -> None:
    from ground.commands import fly_mission
    from ground.core import MissionCmd

    _run(fly_mission(uri, MissionCmd[name], files, out))


@app.command()
def stop(uri: Uri = SIMULATOR_URI) -> None:
    """Emergency: cut the motors at once. The drone falls and stays locked until restarted."""
    from ground.commands import emergency_stop

    _run(emergency_stop(uri, out))


def main() -> None:
    """Entry point."""
    try:
        app()
    except GroundError as error:  # raised while a command's modules were imported
        err.print(f"wayflie: {error}", markup=False)
        sys.exit(1)
