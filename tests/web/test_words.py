# SPDX-License-Identifier: GPL-3.0-or-later
"""What the page says about events on board."""

import json

import pytest

from ground.core import EventCode
from ground.model import Event, Point
from ground.station.station import Station
from ground.web.cockpit import Cockpit
from ground.web.events import events_frame
from tests.ground.fakelink import FakeLink

CODED = (EventCode.STATE, EventCode.REFUSED, EventCode.FAULT, EventCode.SKIPPED)


@pytest.mark.parametrize(("given_up", "level"), [(0, "good"), (1, "warning")])
def test_what_was_given_up_is_not_called_explored(given_up: int, level: str) -> None:
    station = Station(FakeLink())
    station.picture.take(Event(0, 1000, EventCode.EXPLORED, given_up, Point(0.0, 0.0)), 1.0)
    told = json.loads(events_frame(Cockpit(station)))["rows"][0]
    assert told["level"] == level
    assert ("everything" in told["words"]) == (given_up == 0)


@pytest.mark.parametrize("code", EventCode)
def test_every_event_is_told_in_words(code: EventCode) -> None:
    cockpit = Cockpit(Station(FakeLink()))
    assert cockpit.station is not None
    argument = 1 if code in CODED else 99
    cockpit.station.picture.take(Event(1, 100, code, argument, Point(0.0, 0.0)), 0.0)
    assert [bool(event["words"]) for event in json.loads(events_frame(cockpit))["rows"]] == [True]
