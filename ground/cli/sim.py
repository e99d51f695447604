# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie sim`: simulated Crazyflies, each on its own UDP port."""

import contextlib
import os
import signal
from collections.abc import Iterator
from math import inf
from pathlib import Path
from typing import Annotated, Literal

import typer

from ground.checks import write_json
from ground.cli.parts import JsonFile, Profile, Seed, World, err, finish, in_folder, out
from ground.errors import BadInput
from ground.link.uri import SIMULATOR_PORT
from ground.sim.battery import HOVER_ENDURANCE_S
from ground.sim.calls import RecordedFirmware
from ground.sim.console import Lines, obey_one
from ground.sim.faults import parse_fault
from ground.sim.faulttable import FAULTS
from ground.sim.firmware import Firmware
from ground.sim.inputs import InputFile
from ground.sim.positioning import Shadow
from ground.sim.process import READY
from ground.sim.radio import SILENCE_S
from ground.sim.ranger import FALSE_SHORT
from ground.sim.runtime import Options
from ground.sim.server import HOST, Server
from ground.sim.swarm import DRONES_MAX, make_swarm
from ground.sim.trouble import TroubleSpec
from ground.sim.worldfile import read_world

_STANDARD_INPUT = 0

simulator = typer.Typer(add_completion=False, rich_markup_mode="markdown")


def parse_speed(text: str) -> float:
    """Parse "max" or a positive number."""
    if text == "max":
        return inf
    try:
        speed = float(text)
    except ValueError:
        speed = 0.0
    if not 0 < speed < inf:
        raise typer.BadParameter(
            f"{text!r} is neither 'max' nor a positive number", param_hint="--speed"
        )
    return speed


def parse_shadow(text: str) -> Shadow:
    """Parse "START-END" in seconds."""
    start, _, end = text.partition("-")
    try:
        shadow = Shadow(float(start), float(end))
    except ValueError:
        shadow = Shadow(0.0, 0.0)
    if not 0.0 <= shadow.start_s < shadow.end_s < inf:
        raise typer.BadParameter(f"{text!r} is not START-END in seconds", param_hint="--shadow")
    return shadow


@simulator.command()
def sim(
    world: World = "flat",
    port: Annotated[
        int, typer.Option(min=0, max=65535, metavar="PORT", help="UDP port; 0 takes a free one.")
    ] = SIMULATOR_PORT,
    drones: Annotated[
        int,
        typer.Option(
            min=1,
            max=DRONES_MAX,
            metavar="N",
            help="Number of drones, on consecutive ports.",
        ),
    ] = 1,
    speed: Annotated[
        str, typer.Option(help="Simulated seconds per second, or max.", metavar="N|max")
    ] = "1",
    seed: Seed = 1,
    profile: Profile = "real",
    endurance: Annotated[
        float,
        typer.Option(min=1.0, metavar="S", help="Seconds of hovering on one battery."),
    ] = HOVER_ENDURANCE_S,
    false_short: Annotated[
        float,
        typer.Option(
            min=0.0, max=1.0, metavar="SHARE", help="Share of ranges that are falsely too short."
        ),
    ] = FALSE_SHORT,
    positioning: Annotated[
        Literal["flow", "lighthouse", "loco", "mocap"],
        typer.Option(
            metavar="NAME", help="What measures the position: flow, lighthouse, loco or mocap."
        ),
    ] = "flow",
    shadow: Annotated[
        list[str] | None,
        typer.Option(
            help="Period in which Lighthouse or Loco measures nothing, in seconds.", metavar="S-E"
        ),
    ] = None,
    fault: Annotated[
        list[str] | None,
        typer.Option(
            help="Inject a fault at a time and for a while, in simulated seconds: "
            + ", ".join(FAULTS)
            + ".",
            metavar="NAME@T[:S]",
        ),
    ] = None,
    needs_arming: Annotated[
        bool,
        typer.Option(
            "--needs-arming", help="Must be armed, like a Brushless; otherwise it arms itself."
        ),
    ] = False,
    silence: Annotated[
        float,
        typer.Option(
            min=0.1,
            max=3600.0,
            metavar="S",
            help="A client that sends nothing for so long is forgotten, with its log blocks.",
        ),
    ] = SILENCE_S,
    loss: Annotated[
        float,
        typer.Option(
            min=0.0,
            max=0.9,
            metavar="SHARE",
            help="Share of datagrams that are lost, once a client is connected.",
        ),
    ] = 0.0,
    duplication: Annotated[
        float,
        typer.Option(min=0.0, max=0.9, metavar="SHARE", help="Share of datagrams that come twice."),
    ] = 0.0,
    reorder: Annotated[
        float,
        typer.Option(
            min=0.0,
            max=0.9,
            metavar="SHARE",
            help="Share of datagrams that arrive after the next one.",
        ),
    ] = 0.0,
    eeprom: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            callback=in_folder,
            help="File for stored parameters; if not given, they are not kept.",
        ),
    ] = None,
    trail: Annotated[
        bool, typer.Option("--trail", help="Write the true poses into the JSON file.")
    ] = False,
    record_inputs: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            callback=in_folder,
            help="Record all inputs of the app, as MCAP, for `wayflie replay --rerun`.",
        ),
    ] = None,
    with_parent: Annotated[
        bool, typer.Option("--with-parent", help="End when the process that started it has ended.")
    ] = False,
    json_file: JsonFile = None,
) -> None:
    """Simulate a Crazyflie that runs Wayflie, or several, until Ctrl-C.

    While it runs it obeys typed lines: `fault NAME[:SECONDS]` begins a fault, `end NAME` ends it,
    `faults` lists them. A number before the line selects a drone; otherwise it is the first.
    """
    try:
        faults = tuple(parse_fault(text) for text in fault or ())
    except ValueError as error:
        raise typer.BadParameter(str(error), param_hint="--fault") from error
    options = Options(
        seed=seed,
        profile=profile,
        endurance_s=endurance,
        false_short=false_short,
        positioning=positioning,
        shadows=tuple(parse_shadow(text) for text in shadow or ()),
        speed=parse_speed(speed),
        needs_arming=needs_arming,
        silence_s=silence,
        trouble=TroubleSpec(loss, duplication, reorder),
        eeprom_file=eeprom,
        keep_trail=trail,
        faults=faults,
    )

    def work() -> bool:
        with contextlib.ExitStack() as stack:
            told = [stack.enter_context(_inputs(record_inputs, n, world)) for n in range(drones)]
            parent = os.getppid() if with_parent else None
            try:
                _run(world, port, told, options, json_file, parent)
            except ValueError as error:
                raise BadInput(str(error)) from error
        return True

    finish(work)


@contextlib.contextmanager
def _inputs(file: Path | None, number: int, world: str) -> Iterator[Firmware]:
    """A Firmware; if a file is named, one whose inputs are recorded there."""
    if file is None:
        yield Firmware()
        return
    path = file.with_stem(f"{file.stem}-{number + 1}") if number else file
    with contextlib.closing(InputFile(path, {"world": world})) as inputs:
        yield RecordedFirmware(inputs)


def _run(
    world: str,
    port: int,
    told: list[Firmware],
    options: Options,
    json_file: Path | None,
    parent: int | None,
) -> None:
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, frame: signals.append(number))

    lines = Lines(_STANDARD_INPUT)

    def stopped() -> bool:
        over = bool(signals) or parent not in (None, os.getppid())  # then obey the last lines
        for line in lines.take():
            if answer := obey_one(line, [drone.faults for drone in swarm.drones]):
                out.print(answer, markup=False, soft_wrap=True)
        return over

    count = len(told)
    swarm = make_swarm(read_world(world), options, count, told)
    for name in swarm.drones[0].unknown_eeprom_names:
        err.print(f"wayflie: EEPROM: no persistent parameter {name}", markup=False)
    with contextlib.ExitStack() as stack:
        servers = [
            stack.enter_context(Server(drone.radio, port + number if port else 0))
            for number, drone in enumerate(swarm.drones)
        ]
        swarm.warm_up()
        for server, place in zip(servers, swarm.places_m(), strict=True):
            where = f", set down at {place[0]:.2f},{place[1]:.2f}" if count > 1 else ""
            line = f"{READY}udp://{HOST}:{server.port}, world {world}{where}"
            out.print(line, markup=False, soft_wrap=True)
        swarm.run(servers, options.speed, stopped)
    if json_file is not None:
        write_json(json_file, {"world": world, **swarm.status()})
