# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie campaign`: fly with a progress bar, print a table, write report, rows and plot."""

from __future__ import annotations

from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from ground.checks import Check, write_report
from ground.sim.campaign.drawing import draw_flight, draw_results
from ground.sim.campaign.figures import checks, figures
from ground.sim.campaign.flights import Mission, fly
from ground.sim.campaign.rows import Row, RowFile
from ground.sim.campaign.runner import cluster, fly_all, left_to_fly, processes
from ground.sim.world import World
from ground.sim.worldtext import world_text


@dataclass(frozen=True, slots=True)
class Wanted:
    """What to fly, and where to write the results."""

    like: Mission
    """The first mission; the others differ from it in their number only."""
    missions: int
    workers: int
    dask: str | None
    rows: Path | None
    report: Path | None
    plot: Path | None

    def all_missions(self) -> list[Mission]:
        """All missions in order."""
        return [self.mission(number) for number in range(self.missions)]

    def mission(self, number: int) -> Mission:
        """The mission with this number."""
        return replace(self.like, number=number)


def run_campaign(wanted: Wanted, out: Console) -> bool:
    """Fly the missions that are not in the rows file yet. @return all checks hold"""
    file = RowFile(wanted.rows) if wanted.rows else None
    done = file.read() if file else []
    waiting = left_to_fly(wanted.all_missions(), done)
    if done:
        out.print(f"{len(done)} missions are in {wanted.rows} already")
    flown = _fly(wanted, waiting, file, done, out) if waiting else []
    rows = sorted([*done, *flown], key=lambda row: row.number)
    found = figures(rows)
    held = checks(wanted.like.kind, found, wanted.missions)
    _print(found, held, wanted, out)
    if wanted.report is not None:
        like = wanted.like
        said = {"kind": like.kind, "seed": like.seed, "profile": like.profile, "loss": like.loss}
        write_report(wanted.report, {**said, **found}, held)
    if wanted.plot is not None:
        draw_results(rows, wanted.plot)
    return all(check.ok for check in held)


def replay(wanted: Wanted, number: int, world: Path | None, out: Console) -> bool:
    """Fly one mission again; write its world and a drawing if wanted. @return it succeeded"""
    flight = fly(wanted.mission(number))
    for name, value in _told(flight.row):
        out.print(f"  {name:12} [bold]{value}[/]")
    for (x_m, y_m), contact in zip(flight.contacts_m, flight.contacts, strict=True):
        out.print(f"  touched at {x_m:.2f} {y_m:.2f} after {contact}", soft_wrap=True)
    if world is not None:
        world.write_text(world_text(flight.spec), encoding="utf-8")
        options = wanted.mission(number).options()
        out.print(f"  wayflie sim --world {world} --seed {options.seed} --loss {wanted.like.loss}")
        if flight.goal_m is not None:
            x_m, y_m = World(flight.spec).to_map(*flight.goal_m)
            out.print(f"  wayflie goto {x_m:.3f} {y_m:.3f}")
    if wanted.plot is not None:
        draw_flight(flight, wanted.plot)
    return flight.row.ok


def _fly(
    wanted: Wanted, waiting: list[Mission], file: RowFile | None, done: list[Row], out: Console
) -> list[Row]:
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    failed = sum(not row.ok for row in done)
    quiet = not out.is_terminal
    with Progress(*columns, console=out, disable=quiet) as progress, _executor(wanted) as executor:
        bar = progress.add_task(_headline(failed), total=wanted.missions, completed=len(done))

        def tell(row: Row) -> None:
            nonlocal failed
            failed += not row.ok
            progress.update(bar, advance=1, description=_headline(failed))
            if not row.ok:
                progress.print(
                    f"  {row.number:4}  {row.style} {row.task}: {row.cause}; {row.reason}"
                )

        return fly_all(waiting, executor, file, tell)


def _executor(wanted: Wanted) -> AbstractContextManager[Executor]:
    return cluster(wanted.dask) if wanted.dask else processes(wanted.workers)


def _headline(failed: int) -> str:
    return f"{failed} failed" if failed else "flying"


def _told(row: Row) -> list[tuple[str, Any]]:
    pairs = ((name, getattr(row, name)) for name in Row.__dataclass_fields__)
    return [(name, value) for name, value in pairs if value not in (None, "")]


def _print(found: dict[str, Any], held: list[Check], wanted: Wanted, out: Console) -> None:
    failed = {check.name: check for check in held if not check.ok}
    for name, value in found.items():
        if name in ("failures", "reactions") or value is None:
            continue
        limit = f"  must be {failed[name].sense} {failed[name].limit}" if name in failed else ""
        out.print(f"  {name:30} [{'red' if limit else 'bold'}]{value}[/]{limit}")
    if found["failures"]:
        replay_by = f"wayflie campaign --kind {wanted.like.kind} --seed {wanted.like.seed} --only N"
        out.print(f"  fly one again with `{replay_by}`")
