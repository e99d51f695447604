# SPDX-License-Identifier: GPL-3.0-or-later
"""cflib's drivers for radio://, usb://, serial:// and udp://: set-up, scan and small repairs.

With USE_CFLINK=cpp in the environment, cflib uses its native library for radio and USB.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import socket
import sys
import time
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlsplit

import cflib.cpx
import cflib.cpx.transports
import cflib.crtp
import cflib.crtp.radiodriver
import cflib.crtp.serialdriver
import cflib.crtp.udpdriver
import serial
from cflib.cpx.transports import UARTTransport
from cflib.crazyflie import Crazyflie
from cflib.crtp.crtpstack import CRTPPacket
from cflib.crtp.serialdriver import SerialDriver

from ground.errors import BadUri, LinkUnavailable
from ground.link.uri import SCAN_PROBE, SCANNED_PORTS

log = logging.getLogger(__name__)

FORMS = {
    "radio": "radio://0/CHANNEL/RATE/ADDRESS",
    "usb": "usb://0",
    "serial": "serial://DEVICE",
    "udp": "udp://HOST:PORT",
    "tcp": "tcp://HOST:PORT",
}
SYNC_S = 2.0
CLEAR_S = 1.0
SCAN_S = 1.0
SYNC = b"\xff\x00"


class BoundedUart(UARTTransport):  # type: ignore[misc]
    """cflib's CPX over a UART, with time limits; cflib itself waits for the other end for ever."""

    def connect(self) -> None:
        """Wait for the other end's synchronisation bytes and answer them."""
        self._serial = serial.Serial(self._device, self._baudrate, timeout=0.1)
        heard, until_s = b"", time.monotonic() + SYNC_S
        while not heard.endswith(SYNC):
            if time.monotonic() > until_s:
                self._serial.close()
                raise TimeoutError(f"no CPX at {self._device}")
            heard = heard[-1:] + self._serial.read(1)
        self._serial.timeout = None
        self._write_raw(SYNC)
        self._tx_ready.set()

    def disconnect(self) -> None:
        """Close the port and release a thread that waits for a byte."""
        self._serial.cancel_read()
        super().disconnect()

    def clear_to_send(self) -> bool:
        """Whether the other end accepts a packet; waits up to CLEAR_S, but not twice in a row."""
        self._clear = self._tx_ready.wait(CLEAR_S if getattr(self, "_clear", True) else 0.0)
        return bool(self._clear)


class AnySerialDriver(SerialDriver):  # type: ignore[misc]
    """cflib's serial driver, extended to every device file, such as serial:///dev/pts/3."""

    def connect(
        self, uri: str, statistics: Callable[..., None], error: Callable[..., None]
    ) -> None:
        """Open the device of the URI."""
        self._path = uri.removeprefix("serial://")
        super().connect(uri, statistics, error)

    def get_devices(self) -> dict[str, str]:
        """Device files by the names that a URI may use."""
        devices: dict[str, str] = super().get_devices()
        path = getattr(self, "_path", "")
        return devices | {path: path} if Path(path).is_char_device() else devices

    def send_packet(self, packet: CRTPPacket) -> None:
        """Send a packet; it is lost if the other end accepts none within CLEAR_S."""
        if self.cpx and self.cpx._router._transport.clear_to_send():
            super().send_packet(packet)


class NativeStatistics(dict[str, float]):
    """A dict with attributes, which cflib 0.1.34's driver for the native library expects."""

    def __setattr__(self, name: str, value: float) -> None:
        self[name] = value


def init_drivers() -> None:
    """Set up cflib's drivers; needed before any link is opened, and done only once.

    Replaces what cflib's own init_drivers() has set up before, which leaves out serial lines.
    """
    if AnySerialDriver in cflib.crtp.CLASSES:
        return
    cflib.crtp.CLASSES.clear()
    for module in (
        cflib.cpx,
        cflib.cpx.transports,
        cflib.crtp.serialdriver,
        cflib.crtp.radiodriver,
    ):
        module.print = _to_log  # these modules print to the terminal
    logging.getLogger("cflib.crazyflie.toccache").setLevel(logging.ERROR)  # UDP needs no cache
    cflib.crtp.serialdriver.UARTTransport = BoundedUart
    cflib.crtp.SerialDriver = AnySerialDriver
    try:
        cflib.crtp.init_drivers(enable_serial_driver=True)
    except ImportError as error:
        cflib.crtp.CLASSES.clear()
        raise LinkUnavailable(
            f"USE_CFLINK=cpp asks for the Python package cflinkcpp, which is missing ({error})",
            "install it into this environment, or unset USE_CFLINK",
        ) from error
    if native := sys.modules.get("cflib.crtp.cflinkcppdriver"):
        native.__dict__["RadioLinkStatistics"] = NativeStatistics


def check_uri(uri: str) -> None:
    """Raise BadUri if no driver understands the URI."""
    scheme = uri.partition("://")[0]
    if scheme not in FORMS:
        raise BadUri(f"{uri!r} is none of {', '.join(FORMS.values())}")
    with contextlib.suppress(ValueError):
        parts = urlsplit(uri)
        if (parts.hostname and parts.port) or scheme not in ("udp", "tcp"):
            return
    raise BadUri(f"{uri!r} should be {FORMS[scheme]}")


def scan() -> list[str]:
    """URIs of all drones that answer by radio, USB or UDP, and of all serial devices."""
    init_drivers()
    found: list[str] = []
    for driver in dict.fromkeys(cflib.crtp.CLASSES):  # some may be set up more than once
        try:
            udp = driver is cflib.crtp.udpdriver.UdpDriver
            found += _scan_udp() if udp else [uri for uri, *_ in driver().scan_interface(None)]
        except Exception as error:  # of any class; the other drivers may still find something
            log.info("%s found nothing: %s", driver.__name__, error)
    return found


def _scan_udp() -> list[str]:
    """Ask all ports at once; cflib's own scan misses a simulator that is busy for 0.1 s."""
    host = os.environ.get("SCAN_ADDRESS", "127.0.0.1")
    found: set[int] = set()
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for port in SCANNED_PORTS:
            probe.sendto(SCAN_PROBE, (host, port))
        until_s = time.monotonic() + SCAN_S
        while (left_s := until_s - time.monotonic()) > 0:
            probe.settimeout(left_s)
            with contextlib.suppress(TimeoutError):
                found.add(probe.recvfrom(64)[1][1])
    return [f"udp://{host}:{port}" for port in SCANNED_PORTS if port in found]


def cache_folder() -> Path:
    """The folder in which tables of contents are cached."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "wayflie" / "toc"


def last_line(text: str) -> str:
    """The readable part of a message from cflib, which may contain a whole traceback."""
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        return "the link failed"
    return re.sub(r"^\w*(exception|error): ", "", lines[-1].split("] ")[-1].lower())


def hang_up(cf: Crazyflie) -> None:
    """Close the link; under cflib's send lock, since a concurrent send would raise otherwise."""
    cf.link_statistics.stop()
    with cf._send_lock:
        link, cf.link = cf.link, None
    if link:
        link.close()
    cf.close_link()


def _to_log(*words: object) -> None:
    log.debug("cflib: %s", " ".join(map(str, words)))
