# SPDX-License-Identifier: GPL-3.0-or-later
"""What the page says of what happened on board."""

import json

import pytest

from ground.core import EventCode
from ground.model import Event, Point
from ground.station import Station
from ground.web.cockpit import Cockpit
from ground.web.events import events_frame
from tests.ground.fakelink import FakeLink


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
    cockpit.station.picture.take(Event(1, 100, code, 1, Point(0.0, 0.0)), 0.0)
    assert [bool(event["words"]) for event in json.loads(events_frame(cockpit))["rows"]] == [True]
