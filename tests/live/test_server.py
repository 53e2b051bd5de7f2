"""The server over real sockets: who gets what, and that nobody is hurt by somebody else."""

import json
import socket
import threading
import time
import urllib.error
import urllib.request
from contextlib import suppress

import msgpack
import numpy as np
import pytest
from running import HELLO, alone, ask, client, frame, moving, pack, running, singles, unpack
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

from motionmend.bodies.joint_sets import AZURE32, KINECT20, KINECT25
from motionmend.bodies.postures import Postures
from motionmend.errors import FileError
from motionmend.live.address import Address
from motionmend.live.mailbox import MOST_FRAMES
from motionmend.live.messages import MOST_BYTES
from motionmend.live.server import HARD_BYTES, Server


@pytest.fixture(scope="module")
def live(model):
    with running(model) as found:
        yield found


def hello_of(joint_set, fps=30.0):
    return {**HELLO, "skeleton": joint_set.key, "fps": fps}


def test_answers_are_those_of_the_corrector(live, model):
    positions = moving(KINECT20, 20)
    wanted = alone(model, KINECT20, positions)
    with client(live.url) as connection:
        for k, joints in enumerate(positions):
            answer = ask(connection, frame(k, joints))
            assert {"seq", "t_in", "t_out", "joints", "reliability", "flags"} <= set(answer)
            assert answer["seq"] == k
            assert abs(answer["t_in"] - time.time()) < 60
            assert answer["t_out"] >= answer["t_in"]
            assert singles(answer["joints"]).reshape(20, 3) == pytest.approx(wanted[k], abs=1e-6)
            reliability = singles(answer["reliability"])
            assert reliability.shape == (20,)
            assert ((reliability >= 0) & (reliability <= 1)).all()
            assert isinstance(answer["flags"], list)


def test_a_server_that_learns_learns_from_each_client_for_that_client_alone(model):
    cases = [moving(KINECT20, 40, seed) for seed in (1, 2)]
    with running(model, online=True) as live, client(live.url) as one, client(live.url) as other:
        answers = [
            [ask(c, frame(k, p)) for c, p in zip((one, other), at, strict=True)]
            for k, at in enumerate(zip(*cases, strict=True))
        ]
    for number, positions in enumerate(cases):
        found = np.array([singles(pair[number]["joints"]) for pair in answers]).reshape(40, 20, 3)
        assert found == pytest.approx(alone(model, KINECT20, positions, online=True), abs=1e-6)


def test_json_and_msgpack_say_the_same(live):
    positions = moving(KINECT25, 6)
    with client(live.url, hello_of(KINECT25)) as packed, connect(live.url) as text:
        text.send(json.dumps(hello_of(KINECT25)))
        for k, joints in enumerate(positions):
            wanted = singles(ask(packed, frame(k, joints))["joints"])
            text.send(json.dumps({"seq": k, "t": k / 30.0, "joints": joints.tolist(), "state": [2] * 25}))
            answer = json.loads(text.recv(timeout=10))
            assert answer["seq"] == k
            assert np.array(answer["joints"]).shape == (25, 3)
            assert np.array(answer["joints"]).reshape(-1) == pytest.approx(wanted, abs=2e-6)


def test_clients_with_different_skeletons_get_what_they_get_alone(live, model):
    cases = [(KINECT20, 1), (KINECT25, 2), (AZURE32, 3), (KINECT20, 4), (KINECT25, 5), (KINECT20, 6)]
    found: dict[int, np.ndarray] = {}

    def play(number, joint_set, seed):
        with client(live.url, hello_of(joint_set)) as connection:
            raw = [singles(ask(connection, frame(k, p))["joints"]) for k, p in enumerate(moving(joint_set, 25, seed))]
        found[number] = np.array(raw).reshape(25, -1, 3)

    threads = [threading.Thread(target=play, args=(n, *case)) for n, case in enumerate(cases)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    for number, (joint_set, seed) in enumerate(cases):
        assert found[number] == pytest.approx(alone(model, joint_set, moving(joint_set, 25, seed)), abs=1e-6)


HOSTILE = [
    b"", b"\xc1", b"\x91" * 5000, "{", "[]", "[" * 20_000, b"\xff" * 200, pack({}), pack({"seq": 1}),
    pack({**HELLO, "v": 9}), pack({**HELLO, "skeleton": "horse"}), pack({**HELLO, "fps": 0}),
    pack({**HELLO, "units": "inch"}), pack({"seq": 0, "t": 0, "joints": bytes(7)}), bytes(100_000),
]  # fmt: skip


def test_hostile_messages_are_answered_with_errors_and_hurt_nobody_else(live, model):
    positions = moving(KINECT20, len(HOSTILE) + 1)
    wanted = alone(model, KINECT20, positions)
    with client(live.url) as good, connect(live.url) as bad:
        for k, message in enumerate(HOSTILE):
            bad.send(message)
            reply = bad.recv(timeout=10)
            said = json.loads(reply) if isinstance(reply, str) else unpack(reply)
            assert isinstance(reply, str) == isinstance(message, str)
            assert next(iter(said)) == "error"
            assert "\n" not in said["error"]
            assert singles(ask(good, frame(k, positions[k]))["joints"]) == pytest.approx(
                wanted[k].reshape(-1), abs=1e-6
            )
        bad.send(pack(HELLO))  # who was hostile may still behave
        assert ask(bad, frame(0, positions[0]))["seq"] == 0


def test_a_message_without_end_ends_its_own_session_only(live):
    joints = moving(KINECT20, 1)[0]
    with client(live.url) as good, client(live.url) as bad:
        with suppress(ConnectionClosed):  # the server may hang up before it has come
            bad.send(bytes(HARD_BYTES + 1))
        with pytest.raises(ConnectionClosed):
            bad.recv(timeout=10)
        assert ask(good, frame(0, joints))["seq"] == 0


@pytest.mark.parametrize("size", [MOST_BYTES + 1, 2_000_000, HARD_BYTES])
@pytest.mark.parametrize("form", [bytes, lambda size: "[" * size])
def test_a_message_that_is_too_long_is_refused_and_its_session_goes_on(live, size, form):
    joints = moving(KINECT20, 2)
    with client(live.url) as connection:
        assert ask(connection, frame(0, joints[0]))["seq"] == 0
        connection.send(form(size))
        reply = connection.recv(timeout=10)
        said = json.loads(reply) if isinstance(reply, str) else unpack(reply)
        assert f"{MOST_BYTES:,} bytes" in said["error"]
        assert ask(connection, frame(1, joints[1]))["seq"] == 1


def test_a_frame_before_hello_is_refused_and_a_refused_hello_opens_nothing(live):
    joints = moving(KINECT20, 1)[0]
    with client(live.url, {}) as connection:
        assert "hello" in ask(connection, frame(5, joints))["error"]
        assert "skeleton" in ask(connection, {**HELLO, "skeleton": "horse"})["error"]
        refused = ask(connection, frame(6, joints))
        assert "hello" in refused["error"]
        assert refused["seq"] == 6
        connection.send(pack(HELLO))
        assert ask(connection, frame(7, joints))["seq"] == 7
        assert "v: version" in ask(connection, {**HELLO, "v": 3})["error"]
        assert "hello" in ask(connection, frame(8, joints))["error"]


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_not_finite_is_not_seen_and_spoils_no_later_frame(live, model, bad):
    positions = moving(KINECT20, 24)
    wanted = alone(model, KINECT20, positions)
    with client(live.url) as connection, client(live.url) as other:
        for k, joints in enumerate(positions):
            spoilt, codes = joints.copy(), np.full(20, 2, np.uint8)
            if k in (5, 6, 7, 11):
                spoilt[k, 1], codes[k] = bad, 0
            answer = ask(connection, frame(k, spoilt))
            assert answer["joints"] == ask(other, frame(k, spoilt, state=codes))["joints"]
            found = singles(answer["joints"]).reshape(20, 3)
            assert np.isfinite(found).all()
            if k > 15:
                assert np.linalg.norm(found - wanted[k], axis=1).max() < 0.01
        assert np.isnan(singles(ask(connection, frame(30, positions[-1] * bad))["joints"])).all()
        again = singles(ask(connection, frame(31, positions[-1], t=24 / 30.0))["joints"]).reshape(20, 3)
        assert np.linalg.norm(again - wanted[-1], axis=1).max() < 0.02


def test_positions_that_are_no_metres_spoil_no_later_frame(live, model):
    positions = moving(KINECT20, 12)
    wanted = alone(model, KINECT20, positions)
    with client(live.url) as connection:
        for k, joints in enumerate(positions):
            spoilt = joints.copy()
            spoilt[k, 1] = 3e38
            assert "error" in ask(connection, frame(1000 + k, spoilt, t=k / 30.0))
            answer = ask(connection, frame(k, joints))
            assert singles(answer["joints"]).reshape(20, 3) == pytest.approx(wanted[k], abs=1e-6)


def test_a_defect_in_one_client_s_frame_is_that_client_s_alone(live, model, monkeypatch):
    positions = moving(KINECT20, 6)
    wanted = alone(model, KINECT20, positions)
    step = type(model).step

    def broken(self, state, joints, states, t):
        if t == 777.0:
            raise ZeroDivisionError
        return step(self, state, joints, states, t)

    monkeypatch.setattr(type(model), "step", broken)
    with client(live.url) as good, client(live.url) as bad:
        for k, joints in enumerate(positions):
            assert "ZeroDivisionError" in ask(bad, frame(k, joints, t=777.0))["error"]
            answer = ask(good, frame(k, joints))
            assert singles(answer["joints"]).reshape(20, 3) == pytest.approx(wanted[k], abs=1e-6)


def test_a_joint_that_is_not_tracked_may_be_missing(live):
    positions = moving(KINECT20, 12)
    state = np.full(20, 2, np.uint8)
    state[7] = 0
    with client(live.url) as connection:
        for k, joints in enumerate(positions):
            gone = joints.copy()
            gone[7] = np.nan
            answer = ask(connection, frame(k, gone if k > 4 else joints, state=state if k > 4 else None))
            assert "error" not in answer
            assert np.isfinite(np.delete(singles(answer["joints"]).reshape(20, 3), 7, axis=0)).all()
            assert np.isfinite(singles(answer["reliability"])).all()


def test_who_comes_late_is_corrected_as_who_was_there_from_the_beginning(live, model):
    positions = moving(KINECT20, 12)
    wanted = alone(model, KINECT20, positions)
    nobody, untracked = np.full((20, 3), np.nan), np.zeros(20, np.uint8)
    with client(live.url) as connection:
        for k in range(10):
            answer = ask(connection, frame(k, nobody, state=untracked, t=(k - 10) / 30.0))
            assert "error" not in answer
            assert "refused" in answer["flags"]
            assert not np.isfinite(singles(answer["joints"])).any()
            assert not singles(answer["reliability"]).any()
        for k, joints in enumerate(positions):
            answer = ask(connection, frame(10 + k, joints, t=k / 30.0))
            assert singles(answer["joints"]).reshape(20, 3) == pytest.approx(wanted[k], abs=1e-6)


def test_a_new_hello_and_a_clock_that_goes_back_begin_anew(live, model):
    positions = moving(KINECT20, 60)
    wanted = alone(model, KINECT20, positions[:5])
    with client(live.url) as connection:
        for k, joints in enumerate(positions):
            ask(connection, frame(k, joints))
        again = [ask(connection, frame(k, joints)) for k, joints in enumerate(positions[:5])]
        assert "restarted" in again[0]["flags"]
        assert "restarted" not in again[1]["flags"]
        connection.send(pack(HELLO))
        anew = [ask(connection, frame(k, joints)) for k, joints in enumerate(positions[:5])]
    for answers in (again, anew):
        found = np.array([singles(answer["joints"]) for answer in answers]).reshape(5, 20, 3)
        assert found == pytest.approx(wanted, abs=1e-6)


def test_frames_at_the_same_time_are_answered(live):
    joints = moving(KINECT20, 5)
    with client(live.url) as connection:
        for k, t in enumerate([1.0, 1.0, 1.0, 0.9, 1.1]):
            answer = ask(connection, frame(k, joints[k], t=t))
            assert np.isfinite(singles(answer["joints"])).all()


def test_frames_sent_together_are_all_answered_in_their_order(live):
    positions = moving(KINECT20, 4)
    with client(live.url) as connection:
        for again in range(20):
            for k, joints in enumerate(positions):
                connection.send(pack(frame(4 * again + k, joints)))
            found = [unpack(connection.recv(timeout=10))["seq"] for _ in positions]
            assert found == list(range(4 * again, 4 * again + 4))


def test_a_slow_client_loses_its_oldest_frames_and_delays_nobody(model):
    joints = moving(KINECT20, 1)[0]
    many = 1000
    with running(model) as live, client(live.url) as good, socket.socket() as plain:
        plain.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)  # who does not read has little room for answers
        plain.connect((live.address.host, live.address.port))
        with connect(live.url, sock=plain, compression=None, max_queue=1, ping_interval=None) as slow:
            slow.send(pack(HELLO))
            for k in range(many):
                slow.send(pack(frame(k, joints)))
            waits = []
            for k in range(30):
                start = time.perf_counter()
                ask(good, frame(k, joints))
                waits.append(time.perf_counter() - start)
            assert np.median(waits) < 0.5
            seen = [unpack(slow.recv(timeout=20))["seq"]]
            while seen[-1] != many - 1:
                seen.append(unpack(slow.recv(timeout=20))["seq"])
    assert seen == sorted(seen)
    assert len(seen) < many
    assert seen[-MOST_FRAMES:] == list(range(many - MOST_FRAMES, many))
    assert live.server.counts.dropped == many - len(seen)


def test_the_page_is_served_and_nothing_else(live):
    with urllib.request.urlopen(f"http://{live.address}/", timeout=10) as answer:
        text = answer.read().decode()
        policy = answer.headers["Content-Security-Policy"]
        assert answer.headers["Content-Type"].startswith("text/html")
    assert "{{" not in text
    assert "default-src 'none'" in policy
    assert f"ws://{live.address}" in policy
    for path in ("/etc/passwd", "/../serve.py", "/watch"):
        with pytest.raises(urllib.error.HTTPError) as caught:
            urllib.request.urlopen(f"http://{live.address}{path}", timeout=10)
        assert caught.value.code == 404
    with pytest.raises(InvalidStatus):
        connect(f"{live.url}/elsewhere")


def test_other_sites_pages_may_not_connect(live):
    for options in (
        {"origin": "https://evil.example"},
        {"additional_headers": {"Host": "evil.example"}},
    ):
        with pytest.raises(InvalidStatus) as caught:
            connect(live.url, **options)
        assert caught.value.response.status_code == 403
    with connect(live.url, origin=f"http://{live.address}") as own:
        own.send(pack(HELLO))


def test_a_name_that_points_at_this_machine_is_refused(live):
    request = urllib.request.Request(f"http://{live.address}/", headers={"Host": "evil.example"})
    with pytest.raises(urllib.error.HTTPError) as caught:
        urllib.request.urlopen(request, timeout=10)
    assert caught.value.code == 403


def test_a_page_named_beforehand_may_connect(model):
    with running(model, origins=("http://localhost:3000/",)) as live, connect(live.url, origin="http://localhost:3000"):
        pass


def test_stopping_answers_what_has_come_and_says_goodbye(model):
    positions = moving(KINECT20, 4)
    with running(model) as live, client(live.url) as connection:
        ask(connection, frame(0, positions[0]))
        live.halt()
        with pytest.raises(ConnectionClosed) as caught:
            connection.recv(timeout=10)
        assert caught.value.rcvd.code == 1001
    with pytest.raises(OSError):  # noqa: PT011
        connect(live.url)


def test_an_address_in_use_is_said(model, live):
    import asyncio

    with pytest.raises(FileError, match=r"cannot listen on 127\.0\.0\.1"):
        asyncio.run(Server(model).run(live.address, asyncio.Event()))
    with pytest.raises(FileError, match="cannot listen"):
        asyncio.run(Server(model).run(Address("no.such.host.invalid", 0), asyncio.Event()))


def test_a_listener_that_fails_is_left_out_and_the_clients_go_on(model):
    said: list[str] = []

    class Broken:
        def opened(self, *told):
            raise RuntimeError("no")

        frame = closed = wants = opened

    joints = moving(KINECT20, 1)[0]
    with running(model, listeners=[Broken()], say=said.append) as live, client(live.url) as connection:
        assert ask(connection, frame(0, joints))["seq"] == 0
        assert ask(connection, frame(1, joints))["seq"] == 1
    assert len(said) == 1
    assert "Broken" in said[0]


def test_a_crowd_is_turned_away_at_the_door(model, monkeypatch):
    monkeypatch.setattr("motionmend.live.server.MOST_CLIENTS", 2)
    with running(model) as live, client(live.url) as one, client(live.url):
        joints = moving(KINECT20, 1)[0]
        with pytest.raises(InvalidStatus) as caught:
            connect(live.url)
        assert caught.value.response.status_code == 503
        assert ask(one, frame(0, joints))["seq"] == 0


def test_numbers_of_any_packer_are_read(live):
    joints = moving(KINECT20, 1)[0]
    with client(live.url) as connection:
        fields = {**frame(2, joints), "joints": joints.reshape(-1).astype(float).tolist(), "state": [2] * 20, "t": 1}
        answer = ask(connection, fields)
        assert isinstance(answer["joints"], bytes)
        connection.send(msgpack.packb(frame(3, joints), use_bin_type=False))
        assert unpack(connection.recv(timeout=10))["seq"] == 3


@pytest.mark.slow
@pytest.mark.parametrize("text", [False, True])
def test_a_server_that_looks_ahead_answers_late_says_so_and_gives_what_it_owes(model, text):
    positions = moving(KINECT20, 20)
    state = np.full(positions.shape[:2], 2, np.uint8)
    raw = Postures(KINECT20.names, positions.astype(float), np.arange(20) / 30.0, state=state)
    wanted = model.correct(raw, look_ahead=3).positions
    with running(model, look_ahead=0.1) as live, client(live.url) as connection:
        answers = []

        def hear():
            found = connection.recv(timeout=10)
            answers.append(json.loads(found) if isinstance(found, str) else unpack(found))

        for k, joints in enumerate(positions):
            if text:
                fields = {"seq": k, "t": k / 30.0, "joints": joints.tolist(), "state": [2] * 20}
                connection.send(json.dumps(fields))
            else:
                connection.send(pack(frame(k, joints)))
            if k >= 3:
                hear()
        connection.send(json.dumps({"end": True}) if text else pack({"end": True}))
        for _ in range(3):
            hear()
        connection.send(pack({"end": True}))  # nothing is owed: nothing comes
        with pytest.raises(TimeoutError):
            connection.recv(timeout=0.2)
    assert [one["seq"] for one in answers] == list(range(20))
    assert {one["latency_ms"] for one in answers} == {100.0}
    found = np.array([np.ravel(one["joints"]) if text else singles(one["joints"]) for one in answers])
    assert found.reshape(20, 20, 3) == pytest.approx(wanted, abs=1e-4)


@pytest.mark.parametrize(("unit", "told"), [(1e3, True), (1e6, True), (1e7, True), (1.0, False), (10.0, False)])
def test_times_that_are_no_seconds_are_said(model, unit, told):
    """Smoothing would be gone without a word; nor is a slow client one, nor one that paused."""
    positions = moving(KINECT20, 12)
    times = np.arange(12) / 30.0
    times[6:] += 0.0 if told else 60.0
    with running(model) as live, client(live.url) as connection:
        answers = [
            ask(connection, frame(k, one, unit * t)) for k, (one, t) in enumerate(zip(positions, times, strict=True))
        ]
    assert ["clock" in one["flags"] for one in answers] == [told and k >= 3 for k in range(12)]


@pytest.mark.parametrize(
    ("stamp", "told"),
    [
        (lambda k: float(np.float32(1.76e9 + k / 30.0)), True),  # a float of 32 bits has steps of two minutes there
        (lambda k: 7.0 + k, True),  # frames counted
        (lambda k: k // 2 / 15.0, False),  # twice each
        (lambda k: 0.5 * k, False),  # a slow client
    ],
)
def test_a_clock_that_stands_still_or_counts_frames_is_said(model, stamp, told):
    positions = moving(KINECT20, 12)
    with running(model) as live, client(live.url) as connection:
        answers = [ask(connection, frame(k, one, stamp(k))) for k, one in enumerate(positions)]
        again = [ask(connection, frame(k, positions[-1], stamp(11))) for k in range(12, 18)]  # that is no new frame
    assert ["clock" in one["flags"] for one in (*answers, *again)] == [told and 3 <= k < 12 for k in range(18)]


def test_a_clock_that_goes_back_gets_what_was_owed_first(model):
    positions = moving(KINECT20, 6)
    with running(model, look_ahead=0.1) as live, client(live.url) as connection:
        for k, joints in enumerate(positions[:5]):
            connection.send(pack(frame(k, joints, 100.0 + k / 30.0)))
        connection.send(pack(frame(5, positions[5], 0.0)))
        connection.send(pack({"end": True}))
        answers = [unpack(connection.recv(timeout=10)) for _ in range(6)]
    assert [one["seq"] for one in answers] == list(range(6))
    assert ["restarted" in one["flags"] for one in answers] == [False] * 5 + [True]


@pytest.mark.parametrize("good", [True, False])
def test_a_new_hello_brings_what_was_owed_first(model, good):
    positions = moving(KINECT20, 3)
    with running(model, look_ahead=0.1) as live, client(live.url) as connection:
        for k, joints in enumerate(positions):
            connection.send(pack(frame(k, joints)))
        connection.send(pack(HELLO if good else {**HELLO, "v": 9}))
        answers = [unpack(connection.recv(timeout=10)) for _ in range(3)]
        assert [one["seq"] for one in answers] == [0, 1, 2]
        if not good:
            assert "error" in unpack(connection.recv(timeout=10))
