# SPDX-License-Identifier: GPL-3.0-or-later
"""`wayflie bench page`: how soon the page loads, how smooth it is, and what the station costs.

The station is killed in flight, so its recording, which says when each map packet came, is torn.
"""

from __future__ import annotations

import logging
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np
from playwright.sync_api import Browser
from rich.console import Console

from ground.checks import Check, write_report
from ground.model import Incoming
from ground.record.reader import read_recording
from ground.sim.process import SimulatorProcess
from ground.station.picture import Picture
from tests.bench.link.command import table_of
from tests.web.browsing import Tab, chromium, tab_at
from tests.web.grounds import GroundProcess

Figures = dict[str, float | int | None]
LOADS: Final = 7
METER: Final = Path(__file__).with_name("meter.js")
_TICKS_PER_S: Final = os.sysconf("SC_CLK_TCK")
_FIRST_PAINT: Final = """() => new Promise((done) => new PerformanceObserver((list) => {
  for (const entry of list.getEntriesByName("first-contentful-paint")) done(entry.startTime);
}).observe({ type: "paint", buffered: true }))"""


def run_page(json_file: Path | None, seed: int, seconds: float, out: Console) -> bool:
    """Fly an exploration in real time, in front of a browser. @return every check held"""
    figures: Figures = {}
    logging.getLogger("ground.record.reader").setLevel(logging.ERROR)
    with (
        tempfile.TemporaryDirectory(prefix="wayflie-bench-") as folder,
        SimulatorProcess("--world", "flat", "--seed", str(seed)) as simulator,
        chromium() as browser,
    ):
        file = Path(folder) / "flight.mcap"
        with GroundProcess(simulator.uri, record=str(file)) as ground:
            out.print(f"[dim]opening the page {LOADS} times[/]")
            figures |= loading(browser, ground.address)
            out.print(f"[dim]exploring for {seconds:g} s in real time[/]")
            seen, flown = watching(browser, ground, seconds)
        figures |= flown | seeing(seen) | waiting(list(read_recording(file)), seen["maps"])
    checks = checks_of(figures)
    out.print(table_of(figures, checks))
    if json_file:
        write_report(json_file, figures, checks)
    return all(check.ok for check in checks)


def loading(browser: Browser, address: str) -> Figures:
    """Time from navigating to the page until its first paint, with an empty cache."""
    paints_ms = []
    for _ in range(LOADS):
        with tab_at(browser, address) as tab:
            tab.page.goto(address)
            paints_ms.append(tab.page.evaluate(_FIRST_PAINT))
    return {
        "first_paint_s": float(np.median(paints_ms)) / 1000,
        "first_paint_worst_s": max(paints_ms) / 1000,
    }


def watching(
    browser: Browser, ground: GroundProcess, seconds: float
) -> tuple[dict[str, Any], Figures]:
    """What the page notes during an exploration, and what the station costs."""
    with tab_at(browser, ground.address) as tab:
        tab.page.add_init_script(path=METER)
        tab.open()
        tab.page.evaluate("meterPage()")
        _explore(tab)
        tab.page.evaluate("for (const list of Object.values(meter)) list.length = 0")
        begin_s = _cpu_s(ground.pid)
        tab.page.wait_for_timeout(1000 * seconds)
        seen: dict[str, Any] = tab.page.evaluate("meter")
        return seen, {"station_cpu_share": (_cpu_s(ground.pid) - begin_s) / seconds}


def _explore(tab: Tab) -> None:
    """Start exploring, and retry until the position estimate has settled."""
    while not tab.state["can"]["land"]:
        tab.press("Explore")
        tab.page.wait_for_timeout(500)


def _cpu_s(pid: int) -> float:
    """Processor time that a process has used so far, in all its threads."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S


def seeing(seen: dict[str, Any]) -> Figures:
    """Rate and regularity of states and frames."""
    return {
        "state_hz": _rate_hz(seen["states"]),
        "state_gap_worst_s": float(np.diff(seen["states"]).max()) / 1000,
        "draw_hz": _rate_hz(seen["draws"]),
        "draw_gap_p99_ms": float(np.percentile(np.diff(seen["draws"]), 99)),
        "draw_median_ms": float(np.median(seen["draw_ms"])),
        "draw_p99_ms": float(np.percentile(seen["draw_ms"], 99)),
    }


def _rate_hz(times_ms: Sequence[float]) -> float:
    return 1000 * (len(times_ms) - 1) / (times_ms[-1] - times_ms[0])


def waiting(heard: Sequence[tuple[float, Incoming]], maps: Sequence[tuple[int, float]]) -> Figures:
    """Time from the packet that changed the map to the frame that showed it."""
    picture, revision = Picture(), 0
    waits_s = []
    for time_s, message in heard:
        picture.take(message, time_s)
        if picture.map.revision == revision:
            continue
        revision = picture.map.revision
        shown = next((at_ms for drawn, at_ms in maps if drawn >= revision), None)
        if shown is not None and 1000 * time_s >= maps[0][1]:
            waits_s.append(shown / 1000 - time_s)
    return {
        "map_changes": len(waits_s),
        "map_wait_median_s": float(np.median(waits_s)) if waits_s else None,
        "map_wait_p95_s": float(np.percentile(waits_s, 95)) if waits_s else None,
    }


def checks_of(figures: Figures) -> list[Check]:
    """The checks of the page, for a machine that does nothing else."""
    return [
        Check("first_paint_worst_s", figures["first_paint_worst_s"], 1.0, "<="),
        Check("state_hz", figures["state_hz"], 10.0, ">="),
        Check("draw_hz", figures["draw_hz"], 59.0, ">="),
        Check("map_wait_median_s", figures["map_wait_median_s"], 0.5, "<="),
        Check("station_cpu_share", figures["station_cpu_share"], 0.25, "<="),
    ]
