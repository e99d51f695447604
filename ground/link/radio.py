# SPDX-License-Identifier: GPL-3.0-or-later
"""The link over cflib: radio, USB, serial, and UDP to a simulator.

Threads: cflib calls back on its own threads; all that they deliver goes to the asyncio loop through
one Inbox. Calls into cflib may block, so one worker thread makes them all, in order.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import threading
import time
from collections.abc import AsyncIterator, Callable
from typing import TypeVar

from cflib.crazyflie import Crazyflie
from cflib.crazyflie.log import LogConfig
from cflib.crtp.crtpstack import CRTPPacket, CRTPPort

from ground.errors import LinkUnavailable, ProtocolMismatch
from ground.link.drivers import cache_folder, check_uri, hang_up, init_drivers, last_line
from ground.link.inbox import Inbox
from ground.link.logblocks import LogBlock, log_blocks
from ground.link.logstream import LogStream
from ground.link.wire import decode_message, encode_request
from ground.link.worker import Worker
from ground.model import Console, Incoming, LinkChange, LinkState, LinkStats, ParameterValue
from ground.nextsteps import reaching
from ground.requests import EmergencyStop, Outgoing, SetParameter

log = logging.getLogger(__name__)
T = TypeVar("T")

ATTEMPTS = 3
STALL_S = 2.0  # longest pause in a handshake: cflib never repeats a packet that UDP lost
OPENING_S = 10.0  # for the driver to open the link, before any packet
CONNECTING_S = 60.0  # for the whole handshake, even if packets keep coming
SILENT_S = 1.0
LOST_S = 5.0
WATCH_PERIOD_S = 0.05
INBOX_MESSAGES = 4096
UNSENT_MESSAGES = 64


class RadioLink:
    """The link to a Crazyflie at a cflib URI."""

    def __init__(self, uri: str, map_period_ms: int = 20) -> None:
        self.uri = uri
        self._blocks = log_blocks(map_period_ms)
        self._streams: list[tuple[LogStream, LogConfig]] = []
        self._cf: Crazyflie | None = None
        self._inbox: Inbox[Incoming] | None = None
        self._worker = Worker("cflib-calls")
        self._unsent = threading.BoundedSemaphore(UNSENT_MESSAGES)
        self._unsent_dropped = 0
        self._bad_packets = 0
        self._heard_s = 0.0
        self._progress_s = 0.0
        self._watcher: asyncio.Task[None] | None = None

    def parameter(self, name: str) -> float | None:
        """The last known value of a parameter of any group; None if there is no such parameter."""
        group, _, short = name.partition(".")
        known = self._cf.param.values if self._cf else {}
        return float(known[group][short]) if short in known.get(group, {}) else None

    @property
    def latency_ms(self) -> float:
        """Round-trip time as cflib measures it, its 95th percentile; 0 before the first echo."""
        return float(self._cf.link_statistics.latency.latency) if self._cf else 0.0

    @property
    def stats(self) -> LinkStats:
        """Counters since open()."""
        streams = [stream for stream, _ in self._streams]
        dropped = self._inbox.dropped if self._inbox else 0
        return LinkStats(
            log_packets=sum(stream.received for stream in streams),
            lost_packets=sum(stream.lost for stream in streams),
            bad_packets=self._bad_packets + sum(stream.bad for stream in streams),
            dropped_messages=dropped + self._unsent_dropped,
        )

    @property
    def queue_peak(self) -> int:
        """The largest number of messages that ever waited for the reader."""
        return self._inbox.peak if self._inbox else 0

    async def open(self) -> None:
        """Connect, with our own time limits, and start the log blocks."""
        try:
            await self._open()
        except BaseException:
            await self.close()
            raise

    async def _open(self) -> None:
        check_uri(self.uri)
        init_drivers()
        self._inbox = Inbox(asyncio.get_running_loop(), INBOX_MESSAGES)
        for attempt in range(1, ATTEMPTS + 1):
            try:
                self._cf = await self._connect()
                break
            except TimeoutError:
                log.info("connecting to %s stalled (attempt %d)", self.uri, attempt)
        else:
            raise LinkUnavailable(f"{self.uri} answered, but connecting to it was never completed")
        self._prepare_logs(self._cf)
        self._inbox.put(LinkChange(LinkState.CONNECTED, f"connected to {self.uri}"))
        self._watcher = asyncio.create_task(self._watch())

    async def close(self) -> None:
        """Close the link; cflib takes about a second for it."""
        if self._watcher:
            self._watcher.cancel()
            self._watcher = None
        if self._cf:
            cf, self._cf = self._cf, None
            await self._hang_up(cf)
        if self._inbox:
            self._inbox.close()
        self._worker.close()

    def send(self, message: Outgoing) -> None:
        """Pass a message to the worker thread; if too many wait, it is dropped and counted."""
        if self._cf is None:
            return
        if not self._unsent.acquire(blocking=False):
            self._unsent_dropped += 1
            return
        self._worker.submit(self._send_now, self._cf, message)

    async def messages(self) -> AsyncIterator[Incoming]:
        """All incoming messages until the link is closed or lost."""
        assert self._inbox is not None, "open() first"
        while batch := await self._inbox.take():
            for message in batch:
                yield message

    # --- loop ------------------------------------------------------------------------------------

    async def _connect(self) -> Crazyflie:
        loop = asyncio.get_running_loop()
        ready: asyncio.Future[str] = loop.create_future()

        def settle(error: str) -> None:
            loop.call_soon_threadsafe(_settle, ready, error)

        cf = self._new_crazyflie(settle)
        try:
            await asyncio.wait_for(self._call(cf.open_link, self.uri), OPENING_S)
            self._progress_s = begin_s = time.monotonic()
            while not ready.done():
                await asyncio.wait([ready], timeout=0.1)
                now_s = time.monotonic()
                if now_s - self._progress_s > STALL_S or now_s - begin_s > CONNECTING_S:
                    raise TimeoutError
            if error := ready.result():
                why = last_line(error)
                sentence = f"nobody answers at {self.uri} ({why})"
                raise LinkUnavailable(sentence, reaching(self.uri, why))
        except BaseException:
            await self._hang_up(cf)
            raise
        if cf.link is not None:
            # Otherwise an answer lost on UDP makes cflib wait for ever and stop writing parameters.
            cf.link.needs_resending = True
        cf.connection_lost.add_callback(lambda _uri, text: self._lose(last_line(text)))
        return cf

    def _prepare_logs(self, cf: Crazyflie) -> None:
        if "way" not in cf.log.toc.toc:
            raise ProtocolMismatch(f"{self.uri}: this Crazyflie runs no Wayflie app")
        for block in self._blocks:
            config = LogConfig(block.name, block.period_ms)
            for name, fetch_as in block.variables:
                config.add_variable(name, fetch_as)
            try:
                cf.log.add_config(config)
            except KeyError as error:
                if block.required:
                    raise ProtocolMismatch(f"{self.uri}: {error.args[0]}") from error
                log.warning("no %s: %s", block.name, error.args[0])
                continue
            self._streams.append((self._start_stream(block, config), config))

    def _start_stream(self, block: LogBlock, config: LogConfig) -> LogStream:
        assert self._inbox is not None
        stream = LogStream(block, self._inbox.put)
        config.data_received_cb.add_callback(lambda ms, values, _: stream.take(ms, values))
        return stream

    async def _watch(self) -> None:
        """Report silence and loss; set up log blocks again that stay away (lost packet, reset)."""
        assert self._inbox is not None
        silent = False
        while True:
            now_s = time.monotonic()
            if silent != (now_s - self._heard_s > SILENT_S):
                silent = not silent
                state = LinkState.SILENT if silent else LinkState.CONNECTED
                detail = f"nothing heard for {SILENT_S:.0f} s" if silent else "heard again"
                self._inbox.put(LinkChange(state, detail))
            if now_s - self._heard_s > LOST_S:
                self._lose(f"nothing heard for {LOST_S:.0f} s")
                return
            drone_ms = max(stream.drone_ms for stream, _ in self._streams)
            for stream, config in self._streams:
                if stream.overdue(now_s, drone_ms):
                    self._worker.submit(_create_block, config)
            await asyncio.sleep(WATCH_PERIOD_S)

    async def _hang_up(self, cf: Crazyflie) -> None:
        """Close the link on the worker thread; if a driver blocks, stop waiting for it."""
        with contextlib.suppress(TimeoutError):
            await asyncio.wait_for(self._call(hang_up, cf), OPENING_S)

    def _call(self, function: Callable[..., T], *arguments: str) -> asyncio.Future[T]:
        return asyncio.wrap_future(self._worker.submit(function, *arguments))

    # --- worker thread ---------------------------------------------------------------------------

    def _send_now(self, cf: Crazyflie, message: Outgoing) -> None:
        try:
            match message:
                case EmergencyStop():
                    cf.supervisor.send_emergency_stop()
                case SetParameter(name, value):
                    cf.param.set_value(name, value)
                case _:
                    cf.appchannel.send_packet(encode_request(message))
        except Exception as error:  # nothing above a worker thread could report it
            log.warning("could not send %s: %s", message, error)
        finally:
            self._unsent.release()

    # --- cflib's threads: nothing here may raise -------------------------------------------------

    def _new_crazyflie(self, settle: Callable[[str], None]) -> Crazyflie:
        cf = Crazyflie(rw_cache=None if self.uri.startswith("udp://") else str(cache_folder()))
        cf.packet_received.add_callback(self._on_packet)
        cf.fully_connected.add_callback(lambda _uri: settle(""))
        for failed in (cf.connection_failed, cf.connection_lost, cf.disconnected_link_error):
            failed.add_callback(lambda _uri, text: settle(text or "the link failed"))
        cf.appchannel.packet_received.add_callback(self._on_app_packet)
        cf.console.receivedChar.add_callback(lambda text: self._put(Console(text)))
        cf.param.add_update_callback(group="way", cb=self._on_parameter)
        return cf

    def _on_packet(self, packet: CRTPPacket) -> None:
        self._heard_s = time.monotonic()
        if packet.port != CRTPPort.LINKCTRL:
            self._progress_s = self._heard_s

    def _on_app_packet(self, data: bytearray) -> None:
        message = decode_message(bytes(data))
        if message is None:
            self._bad_packets += 1
        else:
            self._put(message)

    def _on_parameter(self, name: str, value: str) -> None:
        self._put(ParameterValue(name, float(value)))

    def _lose(self, detail: str) -> None:
        """From any thread: report the loss and end the messages."""
        self._put(LinkChange(LinkState.LOST, detail))
        if self._inbox:
            self._inbox.close()

    def _put(self, message: Incoming) -> None:
        if self._inbox:
            self._inbox.put(message)


def _settle(ready: asyncio.Future[str], error: str) -> None:
    if not ready.done():
        ready.set_result(error)


def _create_block(config: LogConfig) -> None:
    """Worker thread: (re)create a block; cflib starts it when the drone has acknowledged."""
    config.added = False
    config.start()
