# SPDX-License-Identifier: GPL-3.0-or-later
"""The log of a flight as pages show it: what happened on board, all that the ground has kept."""

from __future__ import annotations

import json
from typing import Any

from ground.link.wire import SEQUENCES
from ground.model import Event
from ground.web.cockpit import Cockpit
from ground.words import event_words


def events_version(cockpit: Cockpit) -> object:
    """Differs whenever there is something new in the log."""
    if cockpit.station is None:
        return None
    events = cockpit.station.picture.events
    return id(events), len(events), events[-1].sequence if events else None


def events_frame(cockpit: Cockpit) -> str:
    """JSON of the log, the newest first, and how many of it were never heard or are left out."""
    events = cockpit.station.picture.events if cockpit.station else ()
    rows = [_row(event) for event in reversed(events)]
    missing = (rows[0]["n"] + 1 - len(rows)) % SEQUENCES if rows else 0
    return json.dumps({"kind": "events", "rows": rows, "missing": missing}, allow_nan=False)


def _row(event: Event) -> dict[str, Any]:
    words, level = event_words(event)
    return {"n": event.sequence, "t": event.drone_ms / 1000, "words": words, "level": level}
