# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie doctor`: examines this machine, the link and the drone; findings have next steps."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from rich.console import Console
from rich.markup import escape

from ground.checks import Check, write_report
from ground.cli.machine import Finding, Verdict, machine
from ground.errors import GroundError, NoAnswer, ProtocolMismatch
from ground.link.radio import RadioLink
from ground.model import Health
from ground.nextsteps import FLASH, PUT_ON, reaching
from ground.progress import share_shown
from ground.station.station import station_on

LOSS_LIMIT = 0.1
LATENCY_LIMIT_MS = 100.0
RESERVE_V = 0.2
COLOURS = {Verdict.GOOD: "green", Verdict.NOTE: "yellow", Verdict.BAD: "red"}
DECKS = {
    "deck.bcFlow2": "the Flow deck v2",
    "deck.bcMultiranger": "the Multi-ranger deck",
}


@dataclass(frozen=True, slots=True)
class Seen:
    """What was heard of a drone while listening."""

    decks: dict[str, float | None] = field(default_factory=dict)
    loss: float = 0.0
    log_packets: int = 0
    bad_packets: int = 0
    latency_ms: float = 0.0
    low_battery_v: float | None = None
    health: Health | None = None


async def examine(uri: str, seconds: float, json_file: Path | None, out: Console) -> bool:
    """Print all findings. @return whether none of them prevents a flight"""
    findings = []
    for finding in machine(uri):
        findings.append(finding)
        _print(finding, out)
    if all(finding.verdict is not Verdict.BAD for finding in findings):
        for finding in await connection(uri, seconds, out):
            findings.append(finding)
            _print(finding, out)
    if json_file:
        figures = {"findings": [finding.as_dict() for finding in findings]}
        checks = [Check(f.what, f.verdict is not Verdict.BAD, True, "==") for f in findings]
        write_report(json_file, figures, checks)
    return all(finding.verdict is not Verdict.BAD for finding in findings)


async def connection(uri: str, seconds: float, out: Console) -> list[Finding]:
    """Connect, listen for a while and judge."""
    link = RadioLink(uri)
    try:
        async with station_on(link) as station:
            begin_s = time.monotonic()
            async with share_shown(
                out, "listening", lambda: (time.monotonic() - begin_s) / seconds
            ):
                await asyncio.sleep(seconds)
            stats = link.stats
            sent = stats.log_packets + stats.lost_packets
            seen = Seen(
                decks={name: link.parameter(name) for name in DECKS},
                loss=stats.lost_packets / sent if sent else 1.0,
                log_packets=stats.log_packets,
                bad_packets=stats.bad_packets,
                latency_ms=link.latency_ms,
                low_battery_v=link.parameter("way.lowBat"),
                health=station.picture.health,
            )
    except GroundError as error:
        return [unreachable(uri, error)]
    return [Finding("connection", Verdict.GOOD, f"a Wayflie answers at {uri}"), *judge(seen)]


def unreachable(uri: str, error: GroundError) -> Finding:
    """Explain why the drone could not be examined."""
    if isinstance(error, NoAnswer):
        sentence = "there is a Wayflie, but it does not answer: another version of the protocol?"
        return Finding("app", Verdict.BAD, sentence, FLASH)
    if isinstance(error, ProtocolMismatch):
        return Finding("app", Verdict.BAD, str(error), FLASH)
    return Finding("connection", Verdict.BAD, str(error), reaching(uri))


def judge(seen: Seen) -> Iterator[Finding]:
    """Findings about a drone that answers."""
    for name, deck in DECKS.items():
        there = bool(seen.decks.get(name))
        if there:
            yield Finding("deck", Verdict.GOOD, f"{deck} is there")
        else:
            yield Finding("deck", Verdict.BAD, f"{deck} is not there", PUT_ON)
    yield from _link(seen)
    if seen.health is None:
        step = "look at `wayflie --verbose doctor`"
        yield Finding("logs", Verdict.BAD, "the drone sends no values about itself", step)
        return
    yield _battery(seen.health.battery_v, seen.low_battery_v)
    yield _supervisor(seen.health)


def _link(seen: Seen) -> Iterator[Finding]:
    words = f"{seen.loss:.1%} of {seen.log_packets} log packets lost"
    step = "come nearer, take another channel (2.4 GHz WiFi is around 0-80), use 2M"
    yield _unless("loss", seen.loss > LOSS_LIMIT, words, step)
    words = f"{seen.latency_ms:.0f} ms round trip"
    step = "end other programs that use this link; a busy computer delays too"
    yield _unless("latency", seen.latency_ms > LATENCY_LIMIT_MS, words, step)
    if seen.bad_packets:
        words = f"{seen.bad_packets} packets that this version does not understand"
        yield Finding("protocol", Verdict.BAD, words, FLASH)


def _unless(what: str, worse: bool, words: str, step: str) -> Finding:
    return Finding(what, Verdict.NOTE, words, step) if worse else Finding(what, Verdict.GOOD, words)


def _battery(battery_v: float, low_v: float | None) -> Finding:
    words, low_v = f"{battery_v:.2f} V", low_v or 0.0
    if battery_v < low_v:
        return Finding("battery", Verdict.BAD, f"{words}: it refuses to fly", "charge it")
    if battery_v < low_v + RESERVE_V:
        return Finding("battery", Verdict.NOTE, f"{words}: a short flight", "charge it")
    return Finding("battery", Verdict.GOOD, words)


def _supervisor(health: Health) -> Finding:
    if health.locked:
        step = "switch it off and on again"
        return Finding("supervisor", Verdict.BAD, "locked after a stop or a crash", step)
    if health.tumbled:
        return Finding("supervisor", Verdict.BAD, "it lies on its side or back", "set it upright")
    if not health.can_fly:
        step = "a Brushless must be armed; props free? level?"
        return Finding("supervisor", Verdict.NOTE, "the firmware does not let it fly now", step)
    return Finding("supervisor", Verdict.GOOD, "the firmware lets it fly")


def _print(finding: Finding, out: Console) -> None:
    mark = f"[{COLOURS[finding.verdict]}]{finding.verdict.value:4}[/]"
    out.print(f"{mark}  {finding.what:12} {escape(finding.sentence)}", soft_wrap=True)
    if finding.next_step:
        out.print(f"      {'':12} -> {escape(finding.next_step)}", soft_wrap=True)
