# SPDX-License-Identifier: GPL-3.0-or-later
"""The command `wayflie`. Heavy modules are imported by the command that needs them."""

from __future__ import annotations

import asyncio
import importlib
import logging
import signal
import sys
from collections.abc import Coroutine
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, NoReturn

import typer
from rich.console import Console
from rich.logging import RichHandler

from ground import __version__
from ground.checks import Files
from ground.errors import GroundError

SIMULATOR_URI = "udp://127.0.0.1:19850"
EXIT_INTERRUPTED = 130

app = typer.Typer(
    name="wayflie",
    help="Lets a Crazyflie map, plan and fly its own way through an unknown room.",
    epilog="Try first: [bold]wayflie demo[/]. Then, in two terminals: [bold]wayflie sim[/] and "
    "[bold]wayflie goto 2.0 1.0[/], or [bold]wayflie ground[/] for the page.",
    rich_markup_mode="rich",
    no_args_is_help=True,
    add_completion=False,
)
map_app = typer.Typer(help="The map that the drone has made.", no_args_is_help=True)
app.add_typer(map_app, name="map")
bench_app = typer.Typer(
    help="Measurements; they need a source checkout (`make setup`).", no_args_is_help=True
)
app.add_typer(bench_app, name="bench")

out = Console(highlight=False)
err = Console(stderr=True, highlight=False, soft_wrap=True)

Uri = Annotated[
    str,
    typer.Option(envvar="CFLIB_URI", help="Which Crazyflie; the simulator's if not given."),
]
JsonFile = Annotated[
    Path | None, typer.Option("--json", help="Write figures and checks to this file.")
]
Record = Annotated[
    Path | None, typer.Option("--record", help="Record the flight into this MCAP file.")
]
Port = Annotated[
    int | None, typer.Option(min=0, max=65535, help="Of the page; the usual or a free one.")
]


def _fail(sentence: str) -> NoReturn:
    err.print(f"wayflie: {sentence}", markup=False)
    raise typer.Exit(1)


def _run(work: Coroutine[Any, Any, bool]) -> None:
    """Run to the end. Exit 0 if it reached what was asked, 1 if not, 130 after Ctrl-C."""
    # Being asked to end is as Ctrl-C: land first.
    signal.signal(signal.SIGTERM, lambda *_: signal.raise_signal(signal.SIGINT))
    try:
        reached = asyncio.run(work)
    except GroundError as error:
        _fail(str(error))
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
) -> None:
    """Fly a simulated Crazyflie through a flat that it has never seen, and watch it."""
    from ground.demo import DemoOptions, run_demo

    _run(run_demo(DemoOptions(world, headless, seed, port, json_file), out))


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


@app.command()
def ground(uri: Uri = SIMULATOR_URI, port: Port = None) -> None:
    """Serve the page for a drone: the map, its state, and buttons to fly it."""
    from ground.commands import serve_ground

    _run(serve_ground(uri, port, out))


@app.command()
def replay(
    file: Annotated[Path, typer.Argument(help="What `wayflie goto --record` has written.")],
    speed: Annotated[float, typer.Option(min=0.1, max=1000.0, help="Times as fast.")] = 1.0,
    port: Port = None,
) -> None:
    """Show a recorded flight on the page again."""
    from ground.commands import replay_flight

    _run(replay_flight(file, speed, port, out))


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


@app.command()
def home(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None) -> None:
    """Fly back to where it took off, and land."""
    _mission("HOME", uri, Files(json_file))


@app.command()
def land(uri: Uri = SIMULATOR_URI, json_file: JsonFile = None) -> None:
    """Land where it is."""
    _mission("LAND", uri, Files(json_file))


def _mission(name: str, uri: str, files: Files) -> None:
    from ground.commands import fly_mission
    from ground.core import MissionCmd

    _run(fly_mission(uri, MissionCmd[name], files, out))


@app.command()
def stop(uri: Uri = SIMULATOR_URI) -> None:
    """Emergency: cut the motors at once. The drone falls and stays locked until restarted."""
    from ground.commands import emergency_stop

    _run(emergency_stop(uri, out))


@map_app.command("save")
def map_save(
    file: Annotated[Path, typer.Argument(help="A .png picture or .npz arrays.")],
    uri: Uri = SIMULATOR_URI,
) -> None:
    """Fetch the whole map from the drone and write it to a file."""
    from ground.commands import fetch_map

    _run(fetch_map(uri, file, out))


def _bench(name: str) -> ModuleType:
    """A measuring module of the checkout."""
    checkout = Path(__file__).resolve().parent.parent
    if not (checkout / "tests" / "bench").exists():
        _fail("bench needs a source checkout: clone the project and run `make setup` there")
    sys.path.insert(0, str(checkout))
    try:
        return importlib.import_module(f"tests.bench.{name}")
    except ImportError as error:
        _fail(f"bench lacks a package ({error}): run `make setup` in the checkout")


@bench_app.command("chip")
def bench_chip(
    json_file: JsonFile = None,
    flights: Annotated[int, typer.Option(min=1, max=20, help="The first so many only.")] = 20,
) -> None:
    """Replay whole flights on an emulated Cortex-M4F: same bits? what do they cost?"""
    if not _bench("chip").run_chip(json_file, flights, out):
        raise typer.Exit(1)


@bench_app.command("slam")
def bench_slam(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the first flight.")] = 1002,
    flights: Annotated[int, typer.Option(min=1, help="So many of each profile.")] = 36,
    profile: Annotated[
        str, typer.Option(help="Of the odometry; stress: the real one in trying rooms.")
    ] = "real,low,hard,perfect,stress",
    flight: Annotated[
        Path | None,
        typer.Option(exists=True, dir_okay=False, help="A recorded flight (.npz) as well."),
    ] = None,
    against: Annotated[
        str | None, typer.Option(help="pf: fly a classic particle filter as well.")
    ] = None,
) -> None:
    """Fly the core's SLAM through simulated rooms: how far off are poses and map?"""
    slam = _bench("slam.command")
    wanted = [name.strip() for name in profile.split(",") if name.strip()]
    if unknown := set(wanted) - set(slam.GROUPS):
        _fail(f"--profile knows {', '.join(slam.GROUPS)}, not {', '.join(sorted(unknown))}")
    if against not in (None, "pf"):
        _fail(f"--against knows pf, not {against}")
    if not slam.run_slam(slam.Wanted(seed, flights, wanted, against, flight), json_file, out):
        raise typer.Exit(1)


@bench_app.command("reloc")
def bench_reloc(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the first home.")] = 1001,
    kidnappings: Annotated[int, typer.Option(min=4, help="Four in each home.")] = 200,
) -> None:
    """Put the drone down somewhere in homes that it knows: does it find out where, and when?"""
    if not _bench("reloc.command").run_reloc(json_file, seed, kidnappings, out):
        raise typer.Exit(1)


@bench_app.command("plan")
def bench_plan(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the problems.")] = 101,
    problems: Annotated[int, typer.Option(min=5, help="So many, of five families.")] = 250,
    against: Annotated[
        str, typer.Option(help="Whom to compare with; ompl needs `make bench-ompl`.")
    ] = "ompl,astar,theta,python",
    seeds: Annotated[int, typer.Option(min=1, help="Runs of each planner on a problem.")] = 3,
    maps: Annotated[
        Path | None, typer.Option(exists=True, help="MovingAI .map files, for the caverns.")
    ] = None,
    plots: Annotated[Path | None, typer.Option(help="Draw pictures into this folder.")] = None,
    reuse: Annotated[
        bool, typer.Option("--reuse", help="Opponents as in an earlier run; nothing to publish.")
    ] = False,
) -> None:
    """Plan on the same problems as OMPL, A* and Theta*: how many times as fast, how short?"""
    plan = _bench("plan.command")
    wanted = tuple(name.strip() for name in against.split(",") if name.strip())
    if unknown := set(wanted) - set(plan.OPPONENTS):
        _fail(f"--against knows {', '.join(plan.OPPONENTS)}, not {', '.join(sorted(unknown))}")
    options = plan.Options(seed, problems, wanted, seeds, maps, reuse, json_file, plots)
    if not plan.run_plan(options, out):
        raise typer.Exit(1)


def main() -> None:
    """Entry point."""
    try:
        app()
    except GroundError as error:  # raised while a command's modules were imported
        err.print(f"wayflie: {error}", markup=False)
        sys.exit(1)
