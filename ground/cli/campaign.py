# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie campaign ...`: many simulated flights, judged by the truth."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Literal

import typer

from ground.cli.parts import MEASURE, JsonFile, Profile, Seed, finish, in_folder, out

Kind = Literal["goto", "moving", "explore", "fault"]

campaigns = typer.Typer(rich_markup_mode="markdown")


@campaigns.command(rich_help_panel=MEASURE)
def campaign(
    kind: Annotated[
        Kind,
        typer.Option(metavar="KIND", help="What to fly: goto, moving, explore or fault."),
    ] = "goto",
    missions: Annotated[int, typer.Option(min=1, help="Number of missions.")] = 100,
    seed: Seed = 1,
    only: Annotated[
        int | None,
        typer.Option(min=0, help="Fly only mission N of these again, and print its whole result."),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(min=1, help="Number of processes; if not given, one per processor."),
    ] = None,
    dask: Annotated[
        str | None,
        typer.Option(
            help="Instead of processes: the address of a dask.distributed scheduler.",
            metavar="ADDR",
        ),
    ] = None,
    resume: Annotated[
        Path | None,
        typer.Option(
            dir_okay=False,
            callback=in_folder,
            help="A CSV file that gets a row as each mission ends; missions in it are not flown "
            "again, so that the same command resumes after an interruption.",
        ),
    ] = None,
    json_file: JsonFile = None,
    plot: Annotated[
        Path | None,
        typer.Option(
            callback=in_folder, help="Draw the results, or the one flight, into this file."
        ),
    ] = None,
    world: Annotated[
        Path | None,
        typer.Option(
            callback=in_folder,
            help="Write the world of --only as TOML, for `wayflie sim --world FILE`.",
        ),
    ] = None,
    profile: Profile = "real",
    loss: Annotated[
        float, typer.Option(min=0.0, max=0.5, help="Share of packets that are lost, each way.")
    ] = 0.02,
    setting: Annotated[
        list[str] | None,
        typer.Option("--set", help="Set a parameter of the drone in all missions.", metavar="P=V"),
    ] = None,
    baseline: Annotated[
        list[str] | None,
        typer.Option(
            help="Explore each world again with this parameter set, to compare the times.",
            metavar="P=V",
        ),
    ] = None,
) -> None:
    """Fly many seeded missions through randomly drawn worlds, and judge them by the truth.

    Exit 0 only if all limits are kept. Ctrl-C leaves finished missions in the --resume file.
    """
    if world and only is None:
        raise typer.BadParameter("--world goes with --only")
    from ground.sim.campaign.command import Wanted, replay, run_campaign
    from ground.sim.campaign.flights import Mission

    like = Mission(
        kind,
        seed,
        0,
        profile,
        loss,
        tuple(_setting(text) for text in setting or ()),
        tuple(_setting(text) for text in baseline or ()),
    )
    wanted = Wanted(like, missions, workers or os.cpu_count() or 1, dask, resume, json_file, plot)
    finish(
        lambda: replay(wanted, only, world, out) if only is not None else run_campaign(wanted, out)
    )


def _setting(text: str) -> tuple[str, float]:
    """Parse a setting such as "way.clearance=0.2"."""
    name, _, value = text.partition("=")
    try:
        return name, float(value)
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not PARAMETER=NUMBER") from None
