# SPDX-License-Identifier: GPL-3.0-or-later
"""Steer a drone for some time, measured by the drone's clock."""

from __future__ import annotations

from ground.core import MissionReason
from ground.errors import LinkLost
from ground.model import Ack, Telemetry
from ground.requests import REST, Stick
from ground.station.station import Station
from ground.words import refusal

SILENCE_S = 2.0
REST_MS = 500  # for which zero velocity is commanded at the end


async def steer_for(station: Station, stick: Stick, seconds: float) -> None:
    """Hold a stick, then let go and wait until it stands. Raises CommandRefused, LinkLost."""
    start_ms = station.picture.drone_ms
    end_ms = start_ms + round(1000 * seconds)
    sent: set[int] = set()
    with station.listen(Telemetry, Ack) as listener:
        while (now_ms := station.picture.drone_ms) < end_ms + REST_MS:
            sent.add(station.send_stick(stick if now_ms < end_ms else REST))
            while not isinstance(message := await listener.next(SILENCE_S), Telemetry):
                if message is None:
                    raise LinkLost(f"the drone was not heard for {SILENCE_S:.0f} s")
                if isinstance(message, Ack) and message.sequence in sent:
                    _judge(message.reason)


def _judge(reason: MissionReason) -> None:
    if reason is not MissionReason.OK:
        raise refusal(reason)
