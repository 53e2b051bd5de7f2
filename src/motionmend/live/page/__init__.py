"""The page at the server's port: one file without any outside request, drawn with the parts of the report's player."""

import re
from base64 import b64encode
from functools import cache
from hashlib import sha256
from importlib.resources import files

from ..address import host_of


@cache
def page() -> str:
    """The page whole, style and script inside."""
    return re.sub(r"\{\{(\w+)\}\}", lambda slot: {"style": _style(), "script": _script()}[slot[1]], _text("live.html"))


def page_headers(host: str) -> dict[str, str]:
    """HTTP headers of the page: it may run its own script and talk to its own server, nothing else.

    Parameters
    ----------
    host : as the browser names the server, port included.
    """
    own = f"ws://{host} wss://{host}" if host_of(host) else ""
    policy = {
        "default-src": "'none'",
        "script-src": _hash(_script()),
        "style-src": _hash(_style()),
        "connect-src": f"'self' {own}".strip(),
        "img-src": "data:",
        "base-uri": "'none'",
        "form-action": "'none'",
        "frame-ancestors": "'none'",
    }
    return {
        "Content-Type": "text/html; charset=utf-8",
        "Content-Security-Policy": "; ".join(f"{name} {value}" for name, value in policy.items()),
        "Cache-Control": "no-store",
        "X-Content-Type-Options": "nosniff",
        "Referrer-Policy": "no-referrer",
    }


@cache
def _style() -> str:
    return _report("player.css") + _text("live.css")


@cache
def _script() -> str:
    return "\n".join(['"use strict";', _report("data.js"), _report("scene.js"), _text("body.js"), _text("live.js")])


def _hash(text: str) -> str:
    """How a policy names an inline script or style that it lets through."""
    return f"'sha256-{b64encode(sha256(text.encode('utf-8')).digest()).decode('ascii')}'"


def _text(name: str) -> str:
    return files(__package__).joinpath(name).read_text(encoding="utf-8")


def _report(name: str) -> str:
    return files("motionmend.report").joinpath(name).read_text(encoding="utf-8")
