# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures of a campaign, computed from its rows, and the limits that they must keep."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np

from ground.checks import Check
from ground.sim.campaign.explore import COMPLETE, LIMIT_S
from ground.sim.campaign.rows import Row

NEAR_M: Final = 0.3
_FAILURES_NAMED: Final = 200


def figures(rows: Sequence[Row]) -> dict[str, Any]:
    """Figures of one campaign; None where nothing was measured."""
    reachable = [row for row in rows if row.task == "reachable"]
    impossible = [row for row in rows if row.task in ("sealed", "inside", "outside")]
    arrived = [row for row in reachable if row.outcome == "arrived"]
    return {
        "missions": len(rows),
        "ok_fraction": _share(row.ok for row in rows),
        "collisions": sum(row.collisions for row in rows),
        "touches": sum(row.touches for row in rows),
        "reachable": len(reachable),
        "reached_fraction": _share(
            row.outcome == "arrived" and row.cause != "arrived elsewhere" for row in reachable
        ),
        "miss_m_median": _median(row.miss_m for row in arrived),
        "within_0_3_m_fraction": _share((row.miss_m or 0.0) <= NEAR_M for row in arrived),
        "length_ratio_median": _median(
            row.flown_m / row.shortest_m for row in arrived if row.flown_m and row.shortest_m
        ),
        "unreachable": len(impossible),
        "unreachable_reported_fraction": _share(
            row.cause in ("", "collision") and row.outcome == "refused" for row in impossible
        ),
        "covered_fraction_median": _median(row.covered for row in rows),
        "known_fraction": _share(
            (row.covered or 0.0) >= COMPLETE for row in rows if row.covered is not None
        ),
        "known_s_median": _median(row.known_s for row in rows),
        "baseline_s_median": _median(row.baseline_s for row in rows),
        "times_as_fast_median": _median(
            row.baseline_s / (row.known_s or LIMIT_S) for row in rows if row.baseline_s is not None
        ),
        "complete_claims": _count(row.claimed for row in rows),
        "complete_claims_false": _count_false_claims(rows),
        "slow_person_near": _count(
            row.person_m < NEAR_M for row in rows if row.person_m is not None
        ),
        "ghosts": _count(row.ghosts for row in rows),
        **_faults([row for row in rows if row.kind == "fault"]),
        "task_s_median": _median(row.task_s for row in rows),
        "sim_s": round(sum(row.sim_s for row in rows), 1),
        "realtime_factor": _factor(rows),
        "causes": dict(Counter(row.cause for row in rows if row.cause).most_common()),
        "failures": [
            {"number": row.number, "style": row.style, "task": row.task, "cause": row.cause,
             "reason": row.reason}
            for row in rows if not row.ok
        ][:_FAILURES_NAMED],
    }  # fmt: skip


def _faults(rows: Sequence[Row]) -> dict[str, Any]:
    if not rows:
        return dict.fromkeys(("faults_happened", "hangs", "stated_fraction", "reactions"))
    happened = [row for row in rows if row.outcome != "not so far"]
    return {
        "faults_happened": len(happened),
        "hangs": sum(row.cause in ("hangs", "the app stopped", "error") for row in rows),
        "stated_fraction": _share(row.ok for row in happened),
        "reactions": reactions(happened),
    }


def reactions(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """For each fault, how often it ended in which state and for which reason."""
    found: dict[str, Counter[str]] = {}
    for row in rows:
        ended = f"{row.outcome}: {row.reason}" if row.reason else row.outcome
        found.setdefault(row.task.split(" / ")[0], Counter())[ended] += 1
    return {fault: dict(ends.most_common()) for fault, ends in found.items()}


def checks(kind: str, found: dict[str, Any], wanted: int) -> list[Check]:
    """The checks of this kind of campaign."""
    common = [
        Check("missions", found["missions"], wanted, "=="),
        Check("collisions", found["collisions"], 0, "=="),
    ]
    return [*common, *_CHECKS[kind](found)]


def _goto(found: dict[str, Any]) -> list[Check]:
    return [
        Check("reached_fraction", found["reached_fraction"], 0.99, ">="),
        Check("length_ratio_median", found["length_ratio_median"], 1.25, "<="),
        Check("unreachable_reported_fraction", found["unreachable_reported_fraction"], 1.0, "=="),
    ]


def _explore(found: dict[str, Any]) -> list[Check]:
    against = found["times_as_fast_median"]
    faster = [] if against is None else [Check("times_as_fast_median", against, 2.0, ">=")]
    return [
        *faster,
        Check("known_fraction", found["known_fraction"], 0.95, ">="),
        Check("complete_claims_false", found["complete_claims_false"], 0, "=="),
    ]


def _moving(found: dict[str, Any]) -> list[Check]:
    return [
        Check("reached_fraction", found["reached_fraction"], 0.97, ">="),
        Check("slow_person_near", found["slow_person_near"], 0, "=="),
        Check("ghosts", found["ghosts"], 0, "=="),
    ]


def _fault(found: dict[str, Any]) -> list[Check]:
    return [
        Check("hangs", found["hangs"], 0, "=="),
        Check("stated_fraction", found["stated_fraction"], 1.0, "=="),
    ]


_CHECKS: Final = {"goto": _goto, "moving": _moving, "explore": _explore, "fault": _fault}


def _share(values: Iterable[bool]) -> float | None:
    given = list(values)
    return round(sum(given) / len(given), 4) if given else None


def _median(values: Iterable[float | None]) -> float | None:
    given = [value for value in values if value is not None]
    return round(float(np.median(given)), 3) if given else None


def _count(values: Iterable[int | None]) -> int | None:
    given = [value for value in values if value is not None]
    return sum(given) if given else None


def _count_false_claims(rows: Sequence[Row]) -> int | None:
    claims = [row for row in rows if row.claimed and row.covered is not None]
    asked = any(row.claimed is not None for row in rows)
    return sum((row.covered or 0.0) < COMPLETE for row in claims) if asked else None


def _factor(rows: Sequence[Row]) -> float | None:
    """Simulated seconds per second of one process."""
    wall_s = sum(row.wall_s for row in rows)
    return round(sum(row.sim_s for row in rows) / wall_s, 1) if wall_s else None
