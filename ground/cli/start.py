# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie` alone, `wayflie demo`, `wayflie sim`."""

from __future__ import annotations

from typing import Annotated, Any

import typer
from rich.console import Console
from typer.core import TyperGroup

from ground.cli.parts import START, JsonFile, Port, Record, Seed, World, end, out, run
from ground.errors import GroundError

DAY = {
    "Without a drone": {
        "wayflie demo": "a simulated drone flies through a flat, on its page",
    },
    "In two terminals": {
        "wayflie sim": "a simulated drone, until Ctrl-C",
        "wayflie ground": "its page: click where it shall go",
    },
    "Instead of the page": {
        "wayflie goto 2.0 1.0": "2 m ahead, 1 m to the left, and land there",
        "wayflie explore": "map all that can be reached, fly home, land",
        "wayflie map save room.png": "what it has seen; .yaml is for ROS",
    },
    "After the flight": {
        "wayflie replay": "the last one again, on the page",
        "wayflie plot": "the same as one picture",
    },
    "With a drone": {
        "wayflie scan": "who answers? tells the URI",
        "wayflie doctor --uri URI": "is anything missing?",
        "wayflie ground --uri URI": "the page; read the README's safety box first",
    },
}

start = typer.Typer()


def welcome(console: Console) -> None:
    """Show what to try first, in the order of a newcomer's day."""
    console.print("[bold]Wayflie lets a Crazyflie map, plan and fly its own way.[/]")
    wide = max(len(line) for lines in DAY.values() for line in lines)
    for title, lines in DAY.items():
        console.print(f"\n[dim]{title}[/]")
        for line, meaning in lines.items():
            console.print(f"  [cyan]{line:{wide}}[/]  {meaning}", soft_wrap=True)
    console.print("\nAll commands: [cyan]wayflie --help[/]", soft_wrap=True)
    console.print(
        "To complete them with Tab: [cyan]wayflie --install-completion[/]", soft_wrap=True
    )


class Commands(TyperGroup):
    """Finds the command to run; imports the simulator for the options of `sim` only. An error ends
    the program here."""

    def invoke(self, ctx: Any) -> Any:  # noqa: ANN401
        """Run a command; end with its error if it fails."""
        try:
            return super().invoke(ctx)
        except GroundError as error:
            end(error)

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[Any, Any, list[str]]:  # noqa: ANN401
        """Find the command for these words, also to complete them."""
        if args[0] != "sim":
            return super().resolve_command(ctx, args)
        from ground.cli.sim import simulator

        return "sim", typer.main.get_command(simulator), args[1:]


@start.command(rich_help_panel=START)
def demo(
    world: World = "flat",
    headless: Annotated[
        bool,
        typer.Option("--headless", help="Without the page, as fast as it can; ends by itself."),
    ] = False,
    seed: Seed = 1,
    port: Port = None,
    json_file: JsonFile = None,
    record: Record = None,
) -> None:
    """Fly a simulated Crazyflie through a flat that it has never seen, and watch it."""
    from ground.cli.demo import DemoOptions, run_demo

    run(run_demo(DemoOptions(world, headless, seed, port, json_file, record), out))


@start.command(rich_help_panel=START)
def sim() -> None:
    """Simulate a Crazyflie, or several, behind UDP ports, until Ctrl-C."""
    raise AssertionError("Commands runs ground.cli.sim instead")
