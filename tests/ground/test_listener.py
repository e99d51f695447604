# SPDX-License-Identifier: GPL-3.0-or-later
"""A listener that waits for an event gets it, whatever else comes in."""

import asyncio

from ground.core import EventCode
from ground.model import Console, Event, Incoming, LinkChange, LinkState, Point
from ground.station.listener import LISTENER_MESSAGES, Listener

EVENT = Event(3, 1000, EventCode.ARRIVED, 1, Point(2.0, 1.0))
CHATTER = [Console("tick\n")] * (LISTENER_MESSAGES + 1)


def heard(listener: Listener, messages: list[Incoming]) -> list[Incoming]:
    async def all_of_it() -> list[Incoming]:
        for message in messages:
            listener.put(message)
        got = []
        while (message := await listener.next(0.01)) is not None:
            got.append(message)
        return got

    return asyncio.run(all_of_it())


def test_no_amount_of_other_messages_pushes_an_event_out() -> None:
    assert heard(Listener(Event), [EVENT, *CHATTER]) == [EVENT]


def test_what_becomes_of_the_link_is_heard_by_all() -> None:
    change = LinkChange(LinkState.RECONNECTING, "silent")
    assert heard(Listener(Event), [change, *CHATTER]) == [change]


def test_without_kinds_the_newest_are_kept() -> None:
    got = heard(Listener(), [EVENT, *CHATTER])
    assert len(got) == LISTENER_MESSAGES
    assert EVENT not in got
