# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench ...`: measurements, whose code is in the tests of a source checkout."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from ground.cli.parts import JsonFile, fail, finish, out

bench_app = typer.Typer(
    help="Measurements; they need a source checkout (`make dev`).", no_args_is_help=True
)


def _bench(name: str) -> ModuleType:
    """Import a module of tests/bench from the checkout."""
    checkout = Path(__file__).resolve().parents[2]
    if not (checkout / "tests" / "bench").exists():
        fail("bench needs a source checkout", "clone the project and run `make dev` there")
    sys.path.insert(0, str(checkout))
    try:
        return importlib.import_module(f"tests.bench.{name}")
    except ImportError as error:
        fail(f"bench lacks a package ({error})", "`make dev` in the checkout")


def _chosen(option: str, listed: str, known: Iterable[str]) -> tuple[str, ...]:
    """Split a comma-separated list and check that all its names are known."""
    names = tuple(name.strip() for name in listed.split(",") if name.strip())
    if unknown := set(names) - set(known):
        raise typer.BadParameter(
            f"{option} knows {', '.join(known)}, not {', '.join(sorted(unknown))}"
        )
    return names


@bench_app.command("chip")
def bench_chip(
    json_file: JsonFile = None,
    flights: Annotated[int, typer.Option(min=1, max=20, help="Only the first N flights.")] = 20,
) -> None:
    """Replay whole flights on an emulated Cortex-M4F: are the bits the same, and at what cost?"""
    finish(lambda: _bench("chip").run_chip(json_file, flights, out))


@bench_app.command("slam")
def bench_slam(
    json_file: JsonFile = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Seed of the first flight.")] = None,
    flights: Annotated[int | None, typer.Option(min=1, help="Flights of each profile.")] = None,
    profile: Annotated[
        str | None,
        typer.Option(
            help="Odometry profiles; stress: profile real in difficult rooms; "
            "kidnapped: drones that are carried away."
        ),
    ] = None,
    flight: Annotated[
        Path | None,
        typer.Option(exists=True, dir_okay=False, help="Include a recorded flight (.npz)."),
    ] = None,
    against: Annotated[
        str | None, typer.Option(help="pf: compare with a classic particle filter.")
    ] = None,
    peer: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="CrazySLAM's checkout: which is faster?"),
    ] = None,
    closed_loop: Annotated[
        bool,
        typer.Option(
            "--closed-loop", help="Instead: goals in the world `flat`, by SLAM and by odometry."
        ),
    ] = False,
    minutes: Annotated[float, typer.Option(min=1.0, help="Length of a closed-loop flight.")] = 10.0,
    plots: Annotated[
        Path | None, typer.Option(help="Draw closed-loop flights into this folder.")
    ] = None,
) -> None:
    """Run the core's SLAM in simulated rooms: how large are the errors of poses and map?"""
    bench = _bench("slam.closed_table" if closed_loop else "slam.command")
    given: dict[str, object] = {"seed": seed, "flights": flights}
    if profile is not None:
        given["groups"] = _chosen("--profile", profile, bench.GROUPS)
    if closed_loop:
        given |= {"minutes": minutes, "plots": plots}
    elif against not in (None, "pf"):
        raise typer.BadParameter(f"--against knows pf, not {against}")
    else:
        given |= {"against": against, "recorded": flight, "peer": peer}
    wanted = bench.Wanted(**{name: value for name, value in given.items() if value is not None})
    finish(lambda: bench.run(wanted, json_file, out))


@bench_app.command("reloc")
def bench_reloc(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the first home.")] = 1001,
    kidnappings: Annotated[int, typer.Option(min=4, help="How many, four per home.")] = 200,
) -> None:
    """Put the drone down in homes that it knows and in others: does it find its place in the map?

    Imported maps, maps kept over a restart and kidnappings in flight have no families of their
    own: the core only reads which cells are unknown, free or occupied, and starts without a pose.
    """
    finish(lambda: _bench("reloc.command").run_reloc(json_file, seed, kidnappings, out))


@bench_app.command("plan")
def bench_plan(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the problems.")] = 101,
    problems: Annotated[int, typer.Option(min=5, help="How many, from five families.")] = 250,
    against: Annotated[
        str, typer.Option(help="Opponents; ompl needs `make bench-ompl`.")
    ] = "ompl,astar,theta,python",
    seeds: Annotated[int, typer.Option(min=1, help="Runs of each planner per problem.")] = 3,
    maps: Annotated[
        Path | None, typer.Option(exists=True, help="MovingAI .map files, for the caverns.")
    ] = None,
    plots: Annotated[Path | None, typer.Option(help="Draw plots into this folder.")] = None,
    reuse: Annotated[
        bool,
        typer.Option(
            "--reuse", help="Take the opponents' times from an earlier run; not for publishing."
        ),
    ] = False,
) -> None:
    """Plan the same problems as OMPL, A* and Theta*: how much faster, how short are the paths?"""
    plan = _bench("plan.command")
    wanted = _chosen("--against", against, plan.OPPONENTS)
    options = plan.Options(seed, problems, wanted, seeds, maps, reuse, json_file, plots)
    finish(lambda: plan.run_plan(options, out))


@bench_app.command("link")
def bench_link(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulated drones.")] = 1,
    minutes: Annotated[
        float, typer.Option(min=0.1, help="How long the four drones fly at the end.")
    ] = 10.0,
) -> None:
    """Measure real cflib over UDP: map stream, losses, commands, reconnecting, four drones."""
    finish(lambda: _bench("link.command").run_link(json_file, seed, minutes, out))


@bench_app.command("page")
def bench_page(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the simulated drone.")] = 1,
    seconds: Annotated[
        float, typer.Option(min=5.0, help="How long to watch an exploration.")
    ] = 30.0,
) -> None:
    """Open the page in Chromium while a drone explores: how soon, how smooth, at what cost?"""
    finish(lambda: _bench("web.command").run_page(json_file, seed, seconds, out))
