# SPDX-License-Identifier: GPL-3.0-or-later
"""A drone in memory behind the Link interface: it answers, and can be deaf, slow or unwilling."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable

from ground.core import Capability, MissionCmd, MissionReason, SelfTest
from ground.model import (
    Ack,
    Health,
    Hello,
    Incoming,
    LinkChange,
    LinkState,
    LinkStats,
    ParameterValue,
    Point,
)
from ground.requests import (
    Command,
    EmergencyStop,
    Heartbeat,
    HelloRequest,
    Outgoing,
    SetParameter,
    Waypoints,
)

LOCKED = Health(1000, 4.0, 0.0, 0, 0, 0, 0, 0, supervisor=1 << 6, self_test=SelfTest.NOT_RUN)
HELLO = Hello(Capability.RRTSTAR, 0, 0.05, 128, Point(-3.2, -3.2))


class FakeLink:
    """Implements Link; `sent` holds all that the station sent, `acts` each command once."""

    def __init__(
        self,
        hears: Callable[[Outgoing], bool] = lambda message: True,
        reason: MissionReason = MissionReason.OK,
        hello: Hello = HELLO,
    ) -> None:
        self.sent: list[Outgoing] = []
        self.acts: list[Command] = []
        self.after: list[Incoming] = []
        """What it says right behind the next acknowledgement."""
        self.on_command: Callable[[Command], None] = lambda command: None
        self._hears = hears
        self._reason = reason
        self._hello = hello
        self._inbox: asyncio.Queue[Incoming | None] = asyncio.Queue()
        self.closed = False

    @property
    def stats(self) -> LinkStats:
        return LinkStats()

    async def open(self) -> None:
        self.say(LinkChange(LinkState.CONNECTED, "connected"))

    async def close(self) -> None:
        self.closed = True
        self._inbox.put_nowait(None)

    def say(self, *messages: Incoming) -> None:
        """Deliver a message to the station."""
        for message in messages:
            self._inbox.put_nowait(message)

    @property
    def idle(self) -> bool:
        """Wait until everything delivered has been taken."""
        return self._inbox.empty()

    def lose(self) -> None:
        """Break the link."""
        self.say(LinkChange(LinkState.LOST, "broken"))
        self._inbox.put_nowait(None)

    def send(self, message: Outgoing) -> None:
        self.sent.append(message)
        if not self._hears(message):
            return
        match message:
            case HelloRequest():
                self.say(self._hello)
            case Command(sequence, cmd):
                if all(act.sequence != sequence for act in self.acts):
                    self.acts.append(message)
                    self.on_command(message)
                self.say(Ack(sequence, cmd, self._reason))
                self.say(*self.after)
                self.after = []
            case Waypoints(sequence):
                self.say(Ack(sequence, MissionCmd.NONE, self._reason))
            case SetParameter(name, value):
                self.say(ParameterValue(name, value))
            case EmergencyStop():
                self.say(LOCKED)

    def count(self, kind: type[Heartbeat] | type[EmergencyStop] | type[HelloRequest]) -> int:
        return sum(isinstance(message, kind) for message in self.sent)

    async def messages(self) -> AsyncIterator[Incoming]:
        while (message := await self._inbox.get()) is not None:
            yield message
