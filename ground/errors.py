# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors of the ground station.

GroundError
+-- CoreMissing
+-- LinkError
|   +-- LinkUnavailable
|   |   +-- BadUri (BadInput too)
|   +-- LinkLost
|   +-- NoAnswer
+-- BadInput
|   +-- BadWaypoints
+-- ProtocolMismatch
+-- CommandRefused
+-- ParameterRefused
+-- NotReached
+-- StopLatched
+-- SimulatorFailed
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ground.core import MissionReason


class GroundError(Exception):
    """Base class: str() is one line for the user, `step` is what to do about it.

    A traceback shows both.
    """

    def __init__(self, sentence: str, step: str = "") -> None:
        super().__init__(sentence)
        self.step = step
        if step:
            self.add_note(f"next: {step}")


class CoreMissing(GroundError):
    """The C core is not compiled."""


class LinkError(GroundError):
    """The link to the drone does not work."""


class LinkUnavailable(LinkError):
    """Nobody answers, or the link cannot be opened."""


class LinkLost(LinkError):
    """The link was open and was lost."""


class NoAnswer(LinkError):
    """A request was repeated, but never answered."""


class ProtocolMismatch(GroundError):
    """The other side runs no Wayflie app, or another version of it."""


class CommandRefused(GroundError):
    """The drone refused a command, for this reason."""

    def __init__(self, sentence: str, reason: MissionReason) -> None:
        super().__init__(sentence)
        self.reason = reason


class ParameterRefused(GroundError):
    """The drone does not accept a value for a parameter."""


class BadInput(GroundError):
    """Invalid input that no drone is needed to reject: a file's ending, a world's name."""


class BadUri(LinkUnavailable, BadInput):
    """A URI that no driver understands."""


class BadWaypoints(BadInput):
    """No waypoints, too many, or too far away."""


class NotReached(GroundError):
    """What was asked was not reached, whether the drone flew or not."""


class StopLatched(GroundError):
    """The emergency stop was pressed and not released."""


class SimulatorFailed(GroundError):
    """The simulator did not start or ended early."""
