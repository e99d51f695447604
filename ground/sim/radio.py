# SPDX-License-Identifier: GPL-3.0-or-later
"""The drone's end of the radio link, without sockets: addressed datagrams in and out."""

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from random import Random

from ground.link.uri import SCAN_PROBE
from ground.link.wire import decode_message
from ground.model import Beat
from ground.sim.crazyflie import Crazyflie, Session
from ground.sim.crtp import APP, BadPacket, Port
from ground.sim.trouble import Trouble, TroubleSpec

Address = tuple[str, int]
SILENCE_S = 1.0
"""After this the firmware forgets a client that sends nothing, and its log blocks."""
_HANDSHAKE_PAUSE_S = 0.2
_HANDSHAKE_PORTS = frozenset((Port.PARAM, Port.LOG, Port.MEMORY))
_AHEAD_MS = 1500
"""Faster-than-real time stops when it is this far ahead of what a ground station has seen."""
_WAIT_S = 3.0
"""It stops no longer than this for a ground station that makes no progress."""


@dataclass(slots=True)
class Client:
    """An address that has sent a packet recently; times are wall time, unless stated otherwise."""

    session: Session
    up: Trouble
    down: Trouble
    heard_s: float
    asked_s: float
    settled: bool = False
    beat_s: float = float("-inf")
    """Wall time at which beat_ms last grew, and the latest drone time that the client has seen."""
    beat_ms: int = 0


@dataclass(slots=True)
class Counters:
    """Counts of datagrams and clients, and of refused packets by reason."""

    received: int = 0
    sent: int = 0
    bad: int = 0
    lost_up: int = 0
    lost_down: int = 0
    unsent: int = 0
    clients: int = 0
    errors: dict[str, int] = field(default_factory=dict)


class Radio:
    """The drone's end of the link; loss and reordering begin after a client's handshake."""

    def __init__(
        self, crazyflie: Crazyflie, trouble: TroubleSpec, seed: int, silence_s: float = SILENCE_S
    ) -> None:
        self.counters = Counters()
        self._crazyflie = crazyflie
        self._spec = trouble
        self._random = Random(seed)
        self._silence_s = silence_s
        self._settled: set[Address] = set()
        """Clients that have ended a handshake once, even if they were forgotten since."""
        self._clients: dict[Address, Client] = {}
        self._outgoing: list[tuple[Address, bytes]] = []
        self.silent = False
        """While set, nothing gets through in either direction."""
        self.late_ms = 0
        """Delay of packets in either direction, after the handshake."""
        self._now_ms = 0
        self._up: deque[tuple[int, Address, bytes]] = deque()
        self._down: deque[tuple[int, Address, bytes]] = deque()

    def connected(self) -> bool:
        """Whether the drone hears any client."""
        return bool(self._clients) and not self.silent

    @property
    def trouble(self) -> TroubleSpec:
        """Loss, duplication and reordering of datagrams, for all clients."""
        return self._spec

    @trouble.setter
    def trouble(self, spec: TroubleSpec) -> None:
        self._spec = spec
        for client in self._clients.values():
            client.up.spec = client.down.spec = spec

    def handshaking(self, now_s: float) -> bool:
        """Whether a client is still reading tables or parameters."""
        return any(
            not client.settled and now_s - client.asked_s < _HANDSHAKE_PAUSE_S
            for client in self._clients.values()
        )

    def outruns(self, now_s: float) -> bool:
        """Whether drone time is too far ahead of a ground station that is still there."""
        return not self.silent and any(
            self._now_ms - client.beat_ms > _AHEAD_MS
            and client.session.logs.running
            and now_s - client.beat_s < _WAIT_S
            and now_s - client.heard_s < self._silence_s
            for client in self._clients.values()
        )

    def receive(self, address: Address, datagram: bytes, now_s: float) -> None:
        """Take a datagram from a client."""
        self.counters.received += 1
        if self.silent:
            self.counters.lost_up += 1
            return
        if datagram == SCAN_PROBE:
            self._scanned(address, now_s)
            return
        if not datagram:
            self._refuse("empty datagram")
            return
        client = self._clients.get(address) or self._welcome(address, now_s)
        client.heard_s = now_s
        _note_beat(client, datagram, now_s)
        if not client.settled:
            self._receive_in_handshake(address, client, datagram, now_s)
            return
        lost_before = client.up.lost
        for arrived in client.up.carry(datagram):
            if self.late_ms:
                self._up.append((self._now_ms + self.late_ms, address, arrived))
            else:
                self._answer(address, client, arrived)
        self.counters.lost_up += client.up.lost - lost_before

    def tick(self, now_ms: int) -> None:
        """Queue what the drone sends up to this firmware time."""
        self._now_ms = now_ms
        while self._up and self._up[0][0] <= now_ms:
            _, address, datagram = self._up.popleft()
            if (known := self._clients.get(address)) is not None:
                self._answer(address, known, datagram)
        for packet, origin in self._crazyflie.news():
            for address, client in self._clients.items():
                if client.session is not origin:
                    self._send(address, client, packet)
        for address, client in self._clients.items():
            for packet in client.session.logs.samples(now_ms):
                self._send(address, client, packet)
        while self._down and self._down[0][0] <= now_ms:
            self._outgoing.append(self._down.popleft()[1:])

    def expire(self, now_s: float) -> None:
        """Forget silent clients and their log blocks."""
        for address, client in list(self._clients.items()):
            if self.silent:
                client.heard_s = now_s
            elif now_s - client.heard_s > self._silence_s:
                del self._clients[address]

    def outgoing(self) -> Iterator[tuple[Address, bytes]]:
        """Take the datagrams that wait to be sent, in order."""
        waiting, self._outgoing = self._outgoing, []
        self.counters.sent += len(waiting)
        return iter(waiting)

    def _scanned(self, address: Address, now_s: float) -> None:
        client = self._clients.get(address)
        if client is not None:
            client.heard_s = now_s
        self._outgoing.append((address, SCAN_PROBE))

    def _welcome(self, address: Address, now_s: float) -> Client:
        up, down = (Trouble(self._spec, self._random) for _ in range(2))
        settled = address in self._settled
        client = Client(self._crazyflie.open_session(), up, down, now_s, now_s, settled)
        self._clients[address] = client
        self.counters.clients += 1
        return client

    def _receive_in_handshake(
        self, address: Address, client: Client, datagram: bytes, now_s: float
    ) -> None:
        if datagram[0] >> 4 in _HANDSHAKE_PORTS:
            client.asked_s = now_s
        self._answer(address, client, datagram)
        client.settled = self._crazyflie.settled(client.session)
        if client.settled:
            self._settled.add(address)

    def _answer(self, address: Address, client: Client, datagram: bytes) -> None:
        try:
            answer = self._crazyflie.answer(client.session, datagram)
        except BadPacket as problem:
            self._refuse(str(problem))
            return
        if answer is not None:
            self._send(address, client, answer)

    def _refuse(self, reason: str) -> None:
        self.counters.bad += 1
        self.counters.errors[reason] = self.counters.errors.get(reason, 0) + 1

    def _send(self, address: Address, client: Client, packet: bytes) -> None:
        if self.silent:
            self.counters.lost_down += 1
            return
        if not client.settled:
            self._outgoing.append((address, packet))
            return
        lost_before = client.down.lost
        for arrived in client.down.carry(packet):
            if self.late_ms:
                self._down.append((self._now_ms + self.late_ms, address, arrived))
            else:
                self._outgoing.append((address, arrived))
        self.counters.lost_down += client.down.lost - lost_before


def _note_beat(client: Client, datagram: bytes, now_s: float) -> None:
    """Note the drone time that a ground station reports to have seen, if this is its beat."""
    if (datagram[0] >> 4, datagram[0] & 3) == APP:
        message = decode_message(datagram[1:])
        if isinstance(message, Beat) and message.drone_ms > client.beat_ms:
            client.beat_s, client.beat_ms = now_s, message.drone_ms
