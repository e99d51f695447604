# SPDX-License-Identifier: GPL-3.0-or-later
"""cflib's drivers for radio://, usb://, serial:// and udp://, set up once; and what they find.

With USE_CFLINK=cpp in the environment cflib takes its native library for radio and USB.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
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
import serial
from cflib.cpx.transports import UARTTransport
from cflib.crazyflie import Crazyflie
from cflib.crtp.crtpstack import CRTPPacket
from cflib.crtp.serialdriver import SerialDriver

from ground.errors import BadUri, LinkUnavailable

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
SYNC = b"\xff\x00"


class BoundedUart(UARTTransport):  # type: ignore[misc]
    """cflib's CPX over a UART, which else would wait for ever for somebody at the other end."""

    def connect(self) -> None:
        """Wait for the other end to say that it is there, and answer."""
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
        """Close, and let go who waits for a byte."""
        self._serial.cancel_read()
        super().disconnect()

    def clear_to_send(self) -> bool:
        """The other end takes another packet; waits for that a while, once."""
        self._clear = self._tx_ready.wait(CLEAR_S if getattr(self, "_clear", True) else 0.0)
        return bool(self._clear)


class AnySerialDriver(SerialDriver):  # type: ignore[misc]
    """cflib's serial driver, for every device that there is a file of: serial:///dev/pts/3."""

    def connect(
        self, uri: str, statistics: Callable[..., None], error: Callable[..., None]
    ) -> None:
        """Open the device of the URI."""
        self._path = uri.removeprefix("serial://")
        super().connect(uri, statistics, error)

    def get_devices(self) -> dict[str, str]:
        """Names of devices, and their files."""
        devices: dict[str, str] = super().get_devices()
        path = getattr(self, "_path", "")
        return devices | {path: path} if Path(path).is_char_device() else devices

    def send_packet(self, packet: CRTPPacket) -> None:
        """Send; who takes nothing for a second has lost the packet."""
        if self.cpx and self.cpx._router._transport.clear_to_send():
            super().send_packet(packet)


class NativeStatistics(dict[str, float]):
    """What cflib 0.1.34's driver of the native library needs where it makes another class."""

    def __setattr__(self, name: str, value: float) -> None:
        self[name] = value


def init_drivers() -> None:
    """Once in a process, before any link is opened."""
    if cflib.crtp.CLASSES:
        return
    for module in (
        cflib.cpx,
        cflib.cpx.transports,
        cflib.crtp.serialdriver,
        cflib.crtp.radiodriver,
    ):
        module.print = _to_log  # they tell on the terminal what belongs into a log
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
    """Raise BadUri for what no driver could understand."""
    scheme = uri.partition("://")[0]
    if scheme not in FORMS:
        raise BadUri(f"{uri!r} is none of {', '.join(FORMS.values())}")
    with contextlib.suppress(ValueError):
        parts = urlsplit(uri)
        if (parts.hostname and parts.port) or scheme not in ("udp", "tcp"):
            return
    raise BadUri(f"{uri!r} should be {FORMS[scheme]}")


def scan() -> list[str]:
    """URIs of all that answers: by radio, USB, UDP; and the serial devices there are."""
    init_drivers()
    found: list[str] = []
    for driver in list(cflib.crtp.CLASSES):
        try:
            found += [uri for uri, *_ in driver().scan_interface(None)]
        except Exception as error:  # each driver has its own; the others may still find something
            log.info("%s found nothing: %s", driver.__name__, error)
    return found


def cache_folder() -> Path:
    """Where tables of contents are kept."""
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "wayflie" / "toc"


def last_line(text: str) -> str:
    """cflib puts whole tracebacks into messages: keep the part that a user can read."""
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        return "the link failed"
    return re.sub(r"^\w*(exception|error): ", "", lines[-1].split("] ")[-1].lower())


def hang_up(cf: Crazyflie) -> None:
    """Close the link. What cflib still sends finds it whole or not at all: else it would raise."""
    cf.link_statistics.stop()
    with cf._send_lock:
        link, cf.link = cf.link, None
    if link:
        link.close()
    cf.close_link()


def _to_log(*words: object) -> None:
    log.debug("cflib: %s", " ".join(map(str, words)))
