# SPDX-License-Identifier: GPL-3.0-or-later
"""Steer a drone for some time, measured by the drone's clock."""

from __future__ import annotations

from ground.core import MissionReason
from ground.errors import LinkLost
from ground.model import Ack, Telemetry
from ground.requests import REST, Stick
from ground.station.listener import Listener
from ground.station.station import Station
from ground.words import refusal

SILENCE_S = 2.0
REST_MS = 500  # for which zero velocity is commanded at the end


async def steer_for(station: Station, stick: Stick, seconds: float) -> None:
    """Hold a stick, then let go and wait until it stands. Raises CommandRefused, LinkLost."""
    sent: set[int] = set()
    with station.listen(Telemetry, Ack) as listener:
        if station.picture.telemetry is None:
            await _telemetry(listener, sent)
        end_ms = station.picture.drone_ms + round(1000 * seconds)
        while station.picture.drone_ms < end_ms:
            sent.add(station.send_stick(stick))
            await _telemetry(listener, sent)
        stands_ms = station.picture.drone_ms + REST_MS
        while station.picture.drone_ms < stands_ms:
            sent.add(station.send_stick(REST))
            await _telemetry(listener, sent)


async def _telemetry(listener: Listener, sent: set[int]) -> None:
    """Wait for the next; a refusal of what was sent is raised."""
    while not isinstance(message := await listener.next(SILENCE_S), Telemetry):
        if message is None:
            raise LinkLost(f"the drone was not heard for {SILENCE_S:.0f} s")
        match message:
            case Ack(sequence, _, reason) if sequence in sent and reason is not MissionReason.OK:
                raise refusal(reason)
