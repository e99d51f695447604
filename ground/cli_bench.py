# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench ...`: measurements, which live in the tests of a source checkout."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Annotated

import typer

from ground.cli_parts import JsonFile, fail, finish, out

bench_app = typer.Typer(
    help="Measurements; they need a source checkout (`make setup`).", no_args_is_help=True
)


def _bench(name: str) -> ModuleType:
    """A measuring module of the checkout."""
    checkout = Path(__file__).resolve().parent.parent
    if not (checkout / "tests" / "bench").exists():
        fail("bench needs a source checkout", "clone the project and run `make setup` there")
    sys.path.insert(0, str(checkout))
    try:
        return importlib.import_module(f"tests.bench.{name}")
    except ImportError as error:
        fail(f"bench lacks a package ({error})", "`make setup` in the checkout")


def _chosen(option: str, listed: str, known: Iterable[str]) -> tuple[str, ...]:
    """The names in a list with commas, all of them known."""
    names = tuple(name.strip() for name in listed.split(",") if name.strip())
    if unknown := set(names) - set(known):
        raise typer.BadParameter(
            f"{option} knows {', '.join(known)}, not {', '.join(sorted(unknown))}"
        )
    return names


@bench_app.command("chip")
def bench_chip(
    json_file: JsonFile = None,
    flights: Annotated[int, typer.Option(min=1, max=20, help="The first so many only.")] = 20,
) -> None:
    """Replay whole flights on an emulated Cortex-M4F: same bits? what do they cost?"""
    finish(lambda: _bench("chip").run_chip(json_file, flights, out))


@bench_app.command("slam")
def bench_slam(
    json_file: JsonFile = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Of the first flight.")] = None,
    flights: Annotated[int | None, typer.Option(min=1, help="So many of each profile.")] = None,
    profile: Annotated[
        str | None,
        typer.Option(
            help="Of the odometry; stress: the real one in trying rooms; kidnapped: lost ones."
        ),
    ] = None,
    flight: Annotated[
        Path | None,
        typer.Option(exists=True, dir_okay=False, help="A recorded flight (.npz) as well."),
    ] = None,
    against: Annotated[
        str | None, typer.Option(help="pf: fly a classic particle filter as well.")
    ] = None,
    peer: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="CrazySLAM's checkout: whose is faster?"),
    ] = None,
    closed_loop: Annotated[
        bool,
        typer.Option(
            "--closed-loop", help="Instead: goals in the world `flat`, by SLAM and by odometry."
        ),
    ] = False,
    minutes: Annotated[float, typer.Option(min=1.0, help="Of a flight in closed loop.")] = 10.0,
    plots: Annotated[
        Path | None, typer.Option(help="Draw flights in closed loop into this folder.")
    ] = None,
) -> None:
    """Fly the core's SLAM through simulated rooms: how far off are poses and map?"""
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
    seed: Annotated[int, typer.Option(min=0, help="Of the first home.")] = 1001,
    kidnappings: Annotated[int, typer.Option(min=4, help="Four in each home.")] = 200,
) -> None:
    """Put the drone down somewhere in homes that it knows, or not: does it find out where?

    Maps imported or kept over a restart and kidnappings in flight are no families of their own: all
    that the core reads of a map is what is unknown, free or occupied, and it begins with nothing.
    """
    finish(lambda: _bench("reloc.command").run_reloc(json_file, seed, kidnappings, out))


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
    wanted = _chosen("--against", against, plan.OPPONENTS)
    options = plan.Options(seed, problems, wanted, seeds, maps, reuse, json_file, plots)
    finish(lambda: plan.run_plan(options, out))


@bench_app.command("link")
def bench_link(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the simulated drones.")] = 1,
    minutes: Annotated[float, typer.Option(min=0.1, help="With four drones, at the end.")] = 10.0,
) -> None:
    """Real cflib over real UDP: map stream, losses, commands, reconnecting, four drones."""
    finish(lambda: _bench("link.command").run_link(json_file, seed, minutes, out))


@bench_app.command("page")
def bench_page(
    json_file: JsonFile = None,
    seed: Annotated[int, typer.Option(min=0, help="Of the simulated drone.")] = 1,
    seconds: Annotated[float, typer.Option(min=5.0, help="To look at an exploration.")] = 30.0,
) -> None:
    """Open the page in Chromium while a drone explores: how soon, how smooth, at what cost?"""
    finish(lambda: _bench("web.command").run_page(json_file, seed, seconds, out))
