# SPDX-License-Identifier: GPL-3.0-or-later
"""What can go wrong on the ground.

GroundError              a sentence for the user, one line, and the next step
+-- CoreMissing          the compiled C core is not there
+-- LinkError            the way to the drone
|   +-- LinkUnavailable  nobody answers, or the link cannot be opened
|   +-- LinkLost         it was there and is gone
|   +-- NoAnswer         a request was repeated and never answered
+-- BadInput             what was asked for cannot be, whatever the drone does
|   +-- BadUri           an address that no driver understands; LinkUnavailable too
|   +-- BadWaypoints     too many, none, or too far away
+-- ProtocolMismatch     the other side runs no Wayflie, or another version
+-- CommandRefused       the drone said no; carries its reason
+-- NotReached           it flew, or not, and what was asked was not reached
+-- StopLatched          the emergency stop was pressed and not released
+-- SimulatorFailed      the simulator did not start or ended early
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ground.core import MissionReason


class GroundError(Exception):
    """Root: str() of it is one line that a user understands; `step`: what to do about it.

    A traceback shows both.
    """

    def __init__(self, sentence: str, step: str = "") -> None:
        super().__init__(sentence)
        self.step = step
        if step:
            self.add_note(f"next: {step}")


class CoreMissing(GroundError):
    """The compiled C core is not there."""


class LinkError(GroundError):
    """The way to the drone does not work."""


class LinkUnavailable(LinkError):
    """Nobody answers, or the link cannot be opened."""


class LinkLost(LinkError):
    """The link was there and is gone."""


class NoAnswer(LinkError):
    """A request was repeated and never answered."""


class ProtocolMismatch(GroundError):
    """The other side runs no Wayflie, or another version of it."""


class CommandRefused(GroundError):
    """The drone said no."""

    def __init__(self, sentence: str, reason: MissionReason) -> None:
        super().__init__(sentence)
        self.reason = reason


class ParameterRefused(GroundError):
    """A parameter does not take the value."""


class BadInput(GroundError):
    """What was asked for cannot be, whatever the drone does: a file's ending, a world's name."""


class BadUri(LinkUnavailable, BadInput):
    """An address that no driver understands."""


class BadWaypoints(BadInput):
    """Too many way points, none, or too far away."""


class NotReached(GroundError):
    """It flew, or not, and what was asked was not reached."""


class StopLatched(GroundError):
    """The emergency stop was pressed and not released."""


class SimulatorFailed(GroundError):
    """The simulator did not start or ended early."""
