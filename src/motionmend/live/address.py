"""Where to listen and where to send: addresses as they stand on the command line."""

import ipaddress
import re
from dataclasses import dataclass
from urllib.parse import urlsplit

from ..errors import UsageError

PORT = 8765
_HEADER = re.compile(r"(\[(?P<number>[0-9a-fA-F:.]+)\]|(?P<name>[A-Za-z0-9_.\-]+))(:[0-9]{1,5})?")


@dataclass(frozen=True)
class Address:
    """A host and a port; port 0 lets the system choose."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"

    @property
    def loopback(self) -> bool:
        """Whether only this machine can reach it."""
        return is_loopback(self.host)


def host_of(header: str) -> str:
    """The host in a Host header without its port; "" where the header is none."""
    found = _HEADER.fullmatch(header)
    return "" if found is None else (found["number"] or found["name"]).lower()


def is_loopback(host: str) -> bool:
    """Whether a name or number of a host means this machine alone."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host.lower().rstrip(".") == "localhost" or host.lower().endswith(".localhost")


def websocket_address(text: str, option: str) -> Address:
    """The address in `ws://HOST[:PORT][/]`; `option` is named in the error.

    Raises
    ------
    UsageError : it is none. wss:// is for a proxy in front of the server.
    """
    try:
        parts = urlsplit(text)
        port = parts.port
    except ValueError:
        parts, port = urlsplit(""), None
    if parts.scheme != "ws" or not parts.hostname or parts.path not in ("", "/") or parts.query or parts.username:
        raise UsageError(f"{option}: an address like ws://127.0.0.1:{PORT} was wanted, came {text!r}")
    return Address(parts.hostname, PORT if port is None else port)


def udp_address(text: str, option: str) -> Address:
    """The address in `HOST:PORT` or `[HOST]:PORT`.

    Raises
    ------
    UsageError : it is none.
    """
    try:
        parts = urlsplit(f"//{text}")
        port = parts.port
    except ValueError:
        parts, port = urlsplit(""), None
    if not parts.hostname or not port or parts.path or parts.username:
        raise UsageError(f"{option}: HOST:PORT such as 127.0.0.1:39539 was wanted, came {text!r}")
    return Address(parts.hostname, port)
