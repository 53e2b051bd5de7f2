"""The live page in a real browser: what somebody sees while clients send."""

import numpy as np
import pytest
from running import HELLO, ask, client, frame, running

from browsing import COUNT
from motionmend.bodies.joint_sets import KINECT20, KINECT25
from motionmend.live.warm import standing

pytestmark = pytest.mark.slow

CORRECTED, RAW = [0, 0x72, 0xB2], [0xD5, 0x5E, 0]


@pytest.fixture(scope="module")
def live(model):
    with running(model) as found:
        yield found


@pytest.fixture
def page(browser, live):
    """The page, open and connected; afterwards its console must be clean and nothing asked of anybody else."""
    said, asked, sockets = [], [], []
    context = browser.new_context(viewport={"width": 1280, "height": 900}, color_scheme="light")
    page = context.new_page()
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda one: sockets.append(one.url))
    page.goto(f"http://{live.address}/")
    page.wait_for_function("() => window.live && live.state().open")
    yield page
    context.close()
    assert said == []
    assert asked == [f"http://{live.address}/"]
    assert set(sockets) == {f"{live.url}/watch"}


def state(page):
    return page.evaluate("live.state()")


def play(connection, joint_set, frames=8, start=0):
    joints = standing(joint_set).astype(np.float32)
    for k in range(start, start + frames):
        ask(connection, frame(k, joints + np.float32(0.01 * k)))


def test_raw_and_corrected_bodies_are_drawn_as_they_come(page, live):
    assert page.is_visible("#hint")
    with client(live.url) as connection:
        play(connection, KINECT20)
        page.wait_for_function("() => live.state().seq === 7")
        assert state(page)["joints"] == 20
        assert not page.is_visible("#hint")
        page.wait_for_function(f"() => ({COUNT})({CORRECTED}) > 100")
        page.click("#side")
        page.wait_for_function(f"() => ({COUNT})({RAW}) > 100")
        page.uncheck("#show-raw")
        page.wait_for_function(f"() => ({COUNT})({RAW}) === 0")
        assert page.locator("#joints tbody tr").count() == 20
        assert "cm" in page.locator("#joints tbody tr td").first.text_content()
        page.click("#joints tbody tr:nth-child(4)")
        page.wait_for_function("() => document.getElementById('now').textContent.startsWith('Head: ')")
        play(connection, KINECT20, 4, start=8)
        page.wait_for_function("() => live.state().seq === 11")
    page.wait_for_function("() => live.state().client === 0")
    assert page.is_visible("#hint")


def test_of_several_clients_one_is_looked_at(page, live):
    second_hello = {**HELLO, "skeleton": "kinect25"}
    with client(live.url) as first:
        play(first, KINECT20)
        page.wait_for_function("() => live.state().joints === 20")
        with client(live.url, second_hello) as second:
            play(second, KINECT25)
            page.wait_for_function("() => live.state().clients.length === 2")
            assert state(page)["joints"] == 20
            page.select_option("#client", str(state(page)["clients"][1]))
            page.wait_for_function("() => live.state().joints === 25")
            play(second, KINECT25, 4, start=20)
            page.wait_for_function("() => live.state().seq === 23")
            page.wait_for_function(f"() => ({COUNT})({CORRECTED}) > 100")
        page.wait_for_function("() => live.state().joints === 20")  # the one looked at has left
        play(first, KINECT20, 2, start=30)
        page.wait_for_function("() => live.state().seq === 31")


def test_names_run_no_code(page, live):
    evil = '<img src=x onerror="window.hacked=1">'
    hello = {**HELLO, "skeleton": "named", "names": [evil, *KINECT20.names[1:]]}
    with client(live.url, hello) as connection:
        play(connection, KINECT20)
        page.wait_for_function("() => live.state().seq === 7")
        assert page.locator("#joints tbody th").first.text_content() == evil
        assert page.locator("img").count() == 0
        assert page.evaluate("window.hacked") is None


def test_everything_fits_a_phone_and_has_a_name(page, live):
    page.set_viewport_size({"width": 360, "height": 740})
    with client(live.url) as connection:
        play(connection, KINECT20)
        page.wait_for_function("() => live.state().seq === 7")
        assert page.evaluate("document.documentElement.scrollWidth") <= 360
        nameless = page.evaluate(
            """() => [...document.querySelectorAll("button, select, input, canvas, meter")].filter((e) =>
            !e.getAttribute("aria-label") && !e.textContent.trim()
            && !(e.closest("label") && e.closest("label").textContent.trim())).map((e) => e.outerHTML)"""
        )
        assert nameless == []
