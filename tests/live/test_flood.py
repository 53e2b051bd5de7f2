"""Who sends on and on and never reads an answer."""

import socket
import time

import pytest
from running import HELLO, pack, running


def send_without_end(connection, message):
    """The same again and again, until nothing more goes in."""
    while True:
        connection.sendall(message)


@pytest.mark.slow
def test_stopping_waits_no_longer_for_who_sends_and_never_reads(model, monkeypatch):
    monkeypatch.setattr("motionmend.live.server.PATIENCE", 0.3)
    with running(model) as live, socket.create_connection(("127.0.0.1", live.address.port), 5) as flood:
        flood.sendall(
            b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
            b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n"
        )
        assert flood.recv(1024).startswith(b"HTTP/1.1 101")
        message = pack(HELLO) + b"!"  # masked with zeros: itself; each is answered by an error
        flood.settimeout(0.5)
        with pytest.raises(TimeoutError):
            send_without_end(flood, bytes([0x82, 0x80 | len(message), 0, 0, 0, 0]) + message)
        start = time.monotonic()
        live.halt()
        while live.loop.is_running():
            assert time.monotonic() - start < 5.0
            time.sleep(0.02)
