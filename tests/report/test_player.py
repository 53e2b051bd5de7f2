"""The page in a real browser: what a reader clicks, presses and sees."""

import numpy as np
import pytest
from test_html import EVIL, arm, spoilt, waving

from browsing import COUNT
from motionmend.bodies.motion import Markers
from motionmend.report import html_report

pytestmark = pytest.mark.slow

BLUE, VERMILLION = [0, 0x72, 0xB2], [0xD5, 0x5E, 0]
PLOT = "document.querySelector('[data-part=plot]').toDataURL()"


@pytest.fixture(scope="module")
def tab(browser):
    """The page in which each test opens its report: making one takes longer than most of what is done in it."""
    context = browser.new_context()
    yield context.new_page()
    context.close()


@pytest.fixture
def player(tab, tmp_path):
    """Opens a report of the given recordings; afterwards the console must be clean and nothing asked of a network."""
    said, asked, opened = [], [], []
    heard = {
        "console": lambda message: said.append(message.text),
        "pageerror": lambda error: said.append(str(error)),
        "request": lambda request: asked.append(request.url),
    }
    for event, listener in heard.items():
        tab.on(event, listener)

    def open_report(named, *, width=1280, height=900, scheme="light", **options):
        path = tmp_path / "report.html"
        html_report(path, named, **options)
        opened.append(path)
        tab.set_viewport_size({"width": width, "height": height})
        tab.emulate_media(color_scheme=scheme)
        tab.mouse.move(0, 0)
        tab.goto(path.as_uri())
        tab.wait_for_function("() => window.report")
        assert asked == [path.as_uri()]
        return tab

    yield open_report
    tab.evaluate("0")  # all that it said until now has been heard
    for event, listener in heard.items():
        tab.remove_listener(event, listener)
    tab.goto("about:blank")
    assert said == []
    assert len(asked) == len(opened)


@pytest.fixture
def take():
    truth = waving()
    noisy, repaired = spoilt(truth)
    return truth, noisy, repaired


def state(page):
    return page.evaluate("report.state()")


def drawn(page, script, *arguments):
    """What a script answers once the page has drawn what was last asked of it: it draws with the next frame."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return page.evaluate(script, *arguments)


def text(page, selector):
    return drawn(page, "(s) => document.querySelector(s).textContent", selector)


def values(page):
    return text(page, "#values")


def test_set_frame_draws_that_frame_of_every_recording(player, take):
    truth, noisy, repaired = take
    page = player([("truth", truth), ("noisy", noisy)], repaired=repaired)
    for frame in (0, 17, 239):
        page.evaluate(f"report.setFrame({frame})")
        shown = state(page)
        assert shown["frame"] == frame
        assert shown["time"] == pytest.approx(frame / 120)
        assert [r["frame"] for r in shown["recordings"]] == [frame] * 3
        assert text(page, "#frame") == f"{frame} / 239"
    page.evaluate("report.setFrame(100000)")
    assert state(page)["frame"] == 239
    page.evaluate("report.setFrame(-3)")
    assert state(page)["frame"] == 0


def test_the_numbers_shown_are_the_recording_s_own(player, take):
    truth, noisy, repaired = take
    page = player([("noisy", noisy), ("truth", truth)], repaired=repaired)
    page.select_option("#channel", "B")
    for frame in (5, 39, 45, 200):
        page.evaluate(f"report.setFrame({frame})")
        x, y, z = truth.positions[frame, 1]
        shown = values(page)
        numbers = [float(v) for v in shown.split("truth ")[1].split(" m")[0].split(",")]
        assert numbers == pytest.approx([x, y, z], abs=6e-4)
        assert ("noisy missing" in shown) == (40 <= frame < 60)
        assert ("± 20.0 mm" in shown) == (40 <= frame < 60)


def test_play_advances_and_space_stops(player, take):
    truth, _, _ = take
    page = player([("take", truth)])
    page.click("#play")
    page.wait_for_function("() => report.state().frame > 10")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press(" ")
    stopped = state(page)
    assert not stopped["playing"]
    page.wait_for_timeout(150)
    assert state(page)["frame"] == stopped["frame"]
    page.select_option("#speed", "4")
    page.evaluate("document.activeElement.blur()")
    page.keyboard.press(" ")
    page.wait_for_function(f"() => report.state().frame < {stopped['frame']}")  # round again
    assert state(page)["playing"]


def test_keys_step_and_jump_and_a_list_keeps_its_own(player, take):
    _, noisy, repaired = take
    page = player([("noisy", noisy)], repaired=repaired)
    for keys, frame in (
        (["ArrowRight"] * 3, 3),
        (["ArrowLeft"], 2),
        (["Shift+ArrowRight"], 12),
        (["End"], 239),
        (["ArrowRight"], 239),
        (["Home"], 0),
    ):
        for key in keys:
            page.keyboard.press(key)
        assert state(page)["frame"] == frame
    page.focus("[data-part=scrubber]")
    page.keyboard.press("ArrowRight")
    assert state(page)["frame"] == 1
    for key, name, value in (("f", "follow", False), ("g", "grid", False), ("s", "layout", "side")):
        page.keyboard.press(key)
        assert state(page)[name] == value
    page.focus("#channel")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("f")
    assert state(page)["frame"] == 1
    assert state(page)["follow"] is False
    page.focus("#grid")
    page.keyboard.press(" ")
    assert state(page)["grid"] is True
    assert not state(page)["playing"]


def test_a_box_hides_its_recording_in_view_and_plot(player, take):
    _, noisy, repaired = take
    page = player([("noisy", noisy)], repaired=repaired)
    page.check("#side")
    before, plotted = drawn(page, COUNT, VERMILLION), drawn(page, PLOT)
    assert before > 50
    page.uncheck("#legend [data-recording='0']")
    assert [r["visible"] for r in state(page)["recordings"]] == [False, True]
    assert drawn(page, COUNT, VERMILLION) == 0
    assert drawn(page, COUNT, BLUE) > 50
    assert drawn(page, PLOT) != plotted
    assert "noisy" not in values(page)
    page.check("#legend [data-recording='0']")
    assert drawn(page, COUNT, VERMILLION) > 50


def test_choosing_a_marker_draws_its_curves_and_tells_what_happened_to_it(player, take):
    truth, noisy, repaired = take
    page = player([("noisy", noisy)], repaired=repaired)
    assert state(page)["channel"] in ("B", "C")  # most samples not measured
    plots = set()
    for name in truth.names:
        page.select_option("#channel", name)
        assert state(page)["channel"] == name
        plots.add(drawn(page, PLOT))
    assert len(plots) == 5
    page.evaluate("report.setFrame(50)")
    assert text(page, "#now") == "1 filled (B)"
    page.evaluate("report.setFrame(110)")
    assert text(page, "#now") == "1 left open (C)"
    page.evaluate("report.setFrame(10)")
    assert text(page, "#now") == "1 repaired (D)"
    page.evaluate("report.setFrame(11)")
    assert "measured" in text(page, "#now")


def test_a_table_s_number_leads_to_the_frame_of_the_largest_change(player, take):
    _, noisy, repaired = take
    page = player([("noisy", noisy)], repaired=repaired)
    page.click(".jump[data-frame] >> nth=0")
    shown = state(page)
    assert shown["channel"] == "D"
    assert shown["frame"] in (10, 30)


def test_strips_and_curves_are_a_scrubber_too_and_the_time_axis_narrows(player, take):
    truth, noisy, repaired = take
    page = player([("noisy", noisy)], repaired=repaired)
    box = page.locator("[data-part=plot]").bounding_box()
    left, right = box["x"] + 112, box["x"] + box["width"] - 14
    page.mouse.click(left + 0.5 * (right - left), box["y"] + 20)
    assert state(page)["time"] == pytest.approx(truth.frames / 240, abs=0.02)
    page.mouse.move(left + 0.5 * (right - left), box["y"] + 20)
    page.mouse.down()
    page.mouse.move(left + 0.25 * (right - left), box["y"] + 20)
    page.mouse.up()
    assert state(page)["time"] == pytest.approx(truth.frames / 480, abs=0.02)
    page.keyboard.press("+")
    page.keyboard.press("+")
    low, high = state(page)["window"]
    assert high - low == pytest.approx(239 / 120 / 4, abs=0.02)
    assert low <= state(page)["time"] <= high
    page.evaluate("report.setFrame(230)")
    low, high = state(page)["window"]
    assert low <= 230 / 120 <= high
    page.keyboard.press("0")
    assert state(page)["window"] == [0, pytest.approx(239 / 120)]
    page.locator("[data-part=rows]").click(position={"x": 20, "y": 2 * 14 + 5})  # third listed row: D
    assert state(page)["channel"] == "D"


def test_the_view_turns_zooms_and_a_click_on_a_marker_chooses_it(player, take):
    truth, _, _ = take
    page = player([("take", truth)])
    view = page.locator("#view").bounding_box()
    x, y = view["x"] + view["width"] * 0.2, view["y"] + view["height"] * 0.6
    first = state(page)["camera"]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 60, y + 30, steps=3)
    page.mouse.up()
    turned = state(page)["camera"]
    assert turned["yaw"] == pytest.approx(first["yaw"] - 0.48)
    assert turned["pitch"] == pytest.approx(first["pitch"] + 0.18)
    page.mouse.wheel(0, -300)
    page.wait_for_function("() => report.state().camera.zoom > 1.2")
    page.click("[data-angle=top]")
    assert state(page)["camera"]["zoom"] == 1
    page.click("[data-angle=front]")
    page.uncheck("#edges")
    page.uncheck("#grid")
    page.wait_for_timeout(100)
    # The markers stand above one another: the highest drawn dot is E, the lowest is A.
    top = page.evaluate(
        """() => {
          const { width, height } = document.getElementById("view");
          const p = document.getElementById("view").getContext("2d").getImageData(0, 0, width, height).data;
          for (let i = 0; i < p.length / 4; i++) if (p[4 * i + 3] > 200) return [i % width, Math.floor(i / width)];
        }"""
    )
    page.mouse.move(view["x"] + top[0], view["y"] + top[1] + 3)
    assert text(page, "#tip") == "E · take"
    page.mouse.click(view["x"] + top[0], view["y"] + top[1] + 3)
    assert state(page)["channel"] == "E"


def test_hands_raised_for_a_part_of_the_time_are_in_view(player):
    places = np.tile([[0, 0.1, 0], [0, -0.1, 0], [0, 0, 1.75], [0, 0.3, 0.8], [0, -0.3, 0.8]], (100, 1, 1))
    places[40:70, 3:, 2] = 2.3
    page = player([("hands up", Markers(tuple("ABCDE"), places, 30.0))])
    page.uncheck("#grid")
    page.evaluate("report.setFrame(55)")
    top, bottom, height = drawn(
        page,
        """() => {
          const { width, height } = document.getElementById("view");
          const p = document.getElementById("view").getContext("2d").getImageData(0, 0, width, height).data;
          const rows = [];
          for (let i = 0; i < p.length / 4; i++) if (p[4 * i + 3] > 200) rows.push(Math.floor(i / width));
          return [rows[0], rows[rows.length - 1], height];
        }""",
    )
    assert 10 < top < bottom < height - 10


def test_recordings_of_other_rates_and_lengths_keep_their_own_time(player, take):
    truth, _, _ = take
    page = player([("take", truth), ("arm", arm(frames=100, fps=50.0)), ("short", waving(frames=60, fps=60.0))])
    assert state(page)["duration"] == pytest.approx(239 / 120)
    page.evaluate("report.setFrame(60)")
    assert [r["frame"] for r in state(page)["recordings"]] == [60, 25, 30]
    page.evaluate("report.setFrame(180)")
    assert [r["frame"] for r in state(page)["recordings"]] == [180, 75, -1]
    page.select_option("#channel", "chest.rz")
    assert "arm" in values(page)
    page.select_option("#provenance", "2")
    assert text(page, "#now") == "short has ended"


def test_a_motion_with_gaps_shows_angles_in_degrees(player):
    truth = arm()
    noisy, repaired = spoilt(truth)
    page = player([("noisy", noisy)], repaired=repaired)
    page.select_option("#channel", "hips.ry")
    page.evaluate("report.setFrame(80)")
    shown = values(page)
    assert float(shown.split("repaired ")[1].split(" ±")[0]) == pytest.approx(
        np.degrees(repaired.recording.q[80, 1]), abs=0.01
    )
    assert shown.endswith("± 0.23°")
    page.evaluate("report.setFrame(50)")
    assert "noisy missing" in values(page)
    assert drawn(page, COUNT, BLUE) > 50


def test_names_run_no_code(player):
    truth = waving(names=(EVIL, "B", "C", "D", "E"))
    noisy, repaired = spoilt(truth)
    page = player([(EVIL, noisy)], repaired=repaired, facts={EVIL: EVIL})
    page.select_option("#channel", EVIL)
    page.evaluate("report.setFrame(45)")
    assert page.evaluate("window.hacked") is None
    assert page.locator("img").count() == 0
    assert EVIL in values(page)
    assert text(page, "#legend span") == EVIL


def test_everything_fits_a_phone_and_follows_the_dark_scheme(player, take):
    truth, noisy, repaired = take
    named = [("truth", truth), ("noisy with quite a long name of its own", noisy)]
    page = player(named, repaired=repaired, width=360, height=740)
    assert page.evaluate("document.documentElement.scrollWidth") <= 360
    light = page.evaluate("getComputedStyle(document.documentElement).backgroundColor")
    page.emulate_media(color_scheme="dark")
    assert page.evaluate("getComputedStyle(document.documentElement).backgroundColor") != light
    page.wait_for_function(f"() => ({COUNT})([0x55, 0xae, 0xea]) > 20")  # the repaired in the dark palette


def test_every_control_has_a_name(player, take):
    truth, noisy, repaired = take
    page = player([("truth", truth), ("noisy", noisy)], repaired=repaired)
    nameless = page.evaluate(
        """() => [...document.querySelectorAll("button, select, input, canvas")].filter((e) =>
        !e.hasAttribute("aria-hidden") && !e.getAttribute("aria-label") && !e.textContent.trim()
        && !(e.closest("label") && e.closest("label").textContent.trim())).map((e) => e.outerHTML)"""
    )
    assert nameless == []


def test_a_long_recording_steps_by_drawn_frames(player):
    truth = waving(frames=4001, fps=240.0)
    noisy, repaired = spoilt(truth)
    page = player([("noisy", noisy)], repaired=repaired)
    page.keyboard.press("ArrowRight")
    assert state(page)["frame"] == 4
    assert [r["frame"] for r in state(page)["recordings"]] == [1, 1]
    page.evaluate("report.setFrame(8)")
    assert text(page, "#now") == "1 repaired (D)"  # frame 10, shown with the three it stands for
    page.keyboard.press("End")
    assert state(page)["frame"] == 4000


def test_nothing_but_gaps_and_a_single_frame_do_not_break_the_player(player):
    still = waving(frames=1)
    nothing = Markers(still.names, np.full((1, 5, 3), np.nan), 60.0)
    page = player([("still", still), ("nothing", nothing)])
    page.keyboard.press("ArrowRight")
    assert state(page)["frame"] == 0
    assert "nothing missing" in values(page)


def test_long_names_and_rates_of_many_digits_leave_room_for_the_last_column(player):
    clip = waving(fps=32.2580645)
    page = player([("m01_s05_e01_positions.txt.gz", clip), ("m01_s05_e01_positions_corrected.csv", clip)])
    wide = page.locator(".wide").first
    assert wide.evaluate("one => one.scrollWidth - one.clientWidth") == 0
