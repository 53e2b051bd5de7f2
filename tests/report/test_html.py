import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from motionmend.bodies.motion import Markers, Motion, Origin, Repaired
from motionmend.bodies.skeleton import Skeleton, positions
from motionmend.errors import FileError, UsageError
from motionmend.report import html_report
from motionmend.report.packed import unpack, unpack_bytes
from motionmend.report.tables import warnings_card

EVIL = '</script><img src=x onerror="window.hacked=1">{{data}}<!--&amp;'


def waving(frames=240, fps=120.0, names=("A", "B", "C", "D", "E"), up=(0.0, 0.0, 1.0)):
    t = np.arange(frames)[:, None] / fps
    k = np.arange(len(names))
    height = 0.3 + 0.35 * k
    place = np.stack(
        [0.8 * t + 0.1 * np.sin(3 * t + k), 0.1 * np.cos(2 * t + k), height + 0.05 * np.sin(4 * t)], axis=2
    )
    return Markers(tuple(names), place, fps, up=np.array(up))


def arm(frames=200, fps=100.0):
    skeleton = Skeleton(
        names=("hips", "chest", "hand", "hand_end"),
        parents=[-1, 0, 1, 2],
        offsets=[[0, 1.0, 0], [0, 0.5, 0], [0.4, 0, 0], [0.2, 0, 0]],
        dof_names=("hips.tx", "hips.ry", "chest.rz", "hand.rz"),
        dof_joint=[0, 0, 1, 2],
        dof_axis=[[1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 1]],
        dof_kind=[1, 0, 0, 0],
        limits=[[-np.inf, np.inf]] * 4,
    )
    t = np.arange(frames)[:, None] / fps
    return Motion(skeleton, 0.6 * np.sin(t * [0.5, 1, 2, 3]), fps, guesses=("no unit: took 1 m",))


def spoilt(truth, seed=3):
    """A copy with noise, one gap and outliers, and what a repair might say of it."""
    rng = np.random.default_rng(seed)
    clean = truth.positions if isinstance(truth, Markers) else truth.q
    noisy = clean + rng.normal(0, 0.01, clean.shape)
    origin = np.zeros((truth.frames, len(truth.channels)), np.uint8)
    origin[40:60, 1], origin[100:120, 2], origin[[10, 30], 3] = Origin.FILLED, Origin.LEFT_OPEN, Origin.REPAIRED
    noisy[origin >= Origin.FILLED] = np.nan
    noisy[origin == Origin.REPAIRED] += 0.5
    mended = clean + rng.normal(0, 0.001, clean.shape)
    mended[origin == Origin.LEFT_OPEN] = np.nan
    std = np.where(origin == Origin.FILLED, 0.02, 0.004)
    std[origin == Origin.LEFT_OPEN] = np.nan
    make = truth.with_positions if isinstance(truth, Markers) else truth.with_q
    repaired = Repaired(
        make(mended), origin, std, (origin == 0).astype(float), "paper", 4, np.array([9.0, 2.0]), True, ("one <gap>",)
    )
    return make(noisy), repaired


class Page(HTMLParser):
    """The page as a browser's parser sees it."""

    def __init__(self, text):
        super().__init__()
        self.text, self.tags, self.words, self.inside = text, [], [], None
        self.scripts = {}
        self.feed(text)
        self.data = json.loads(self.scripts["application/json"])

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag in ("script", "style"):
            self.inside = dict(attrs).get("type", tag)

    def handle_endtag(self, tag):
        if tag in ("script", "style"):
            self.inside = None

    def handle_data(self, data):
        if self.inside:
            self.scripts[self.inside] = self.scripts.get(self.inside, "") + data
        else:
            self.words.append(data)

    @property
    def shown(self):
        return " ".join(" ".join(self.words).split())


def page_of(tmp_path, *args, **options):
    path = tmp_path / "report.html"
    html_report(path, *args, **options)
    return Page(path.read_text(encoding="utf-8"))


def test_the_page_names_no_address_and_loads_nothing(tmp_path):
    truth = waving()
    noisy, repaired = spoilt(truth)
    page = page_of(tmp_path, [("truth", truth), ("noisy", noisy)], repaired=repaired, facts={"model": "m.mend"})
    assert not re.search(r"https?:|//[a-z]|@import|url\(", re.sub(r"//[ A-Z].*", "", page.text))
    assert not any(attrs.get("src") for _, attrs in page.tags)
    assert [a["href"] for _, a in page.tags if a.get("href")] == ["data:,"]
    policy = next(a["content"] for _, a in page.tags if a.get("http-equiv") == "Content-Security-Policy")
    assert "connect-src 'none'" in policy
    assert "script-src-elem 'unsafe-inline'" in policy


def test_positions_and_angles_come_back_within_half_the_stated_step(tmp_path):
    truth = arm()
    noisy, repaired = spoilt(truth)
    page = page_of(tmp_path, [("noisy", noisy), ("repaired", repaired.recording)], repaired=repaired)
    for block, recording in zip(page.data["recordings"], (noisy, repaired.recording), strict=True):
        wanted = positions(recording.skeleton, recording.q).reshape(recording.frames, -1)
        for stored, values in ((block["positions"], wanted), (block["values"], recording.q)):
            back = unpack(stored)
            assert np.array_equal(np.isnan(back), np.isnan(values))
            assert np.nanmax(np.abs(back - values)) <= 0.5e-4 * 1.0001
    assert "0.1 mm and 0.0057°" in page.shown
    std = unpack(page.data["recordings"][1]["std"])
    assert np.nanmax(np.abs(std - repaired.std)) <= 0.5e-4 * 1.0001
    assert np.array_equal(unpack_bytes(page.data["recordings"][1]["state"]), repaired.origin)


def test_names_cannot_break_out_of_the_page(tmp_path):
    markers = waving(names=(EVIL, "B", "C", "D", "E"))
    noisy, repaired = spoilt(markers)
    page = page_of(tmp_path, [(EVIL, noisy)], repaired=repaired, facts={EVIL: EVIL})
    assert page.data["recordings"][0]["name"] == EVIL
    assert page.data["recordings"][0]["channels"][0] == EVIL
    assert not [tag for tag, _ in page.tags if tag == "img"]
    assert EVIL in "".join(page.words)
    assert sum(tag == "script" for tag, _ in page.tags) == 2
    assert page.text.count("</script>") == 2


def test_a_name_that_is_no_utf_8_is_shown_escaped_and_costs_nobody_the_page(tmp_path):
    html_report(tmp_path / "a.html", [("n\udcff.c3d", waving())])
    assert "n\\udcff.c3d" in (tmp_path / "a.html").read_text("utf-8")


def test_the_tables_count_every_sample_and_name_the_largest_change(tmp_path):
    truth = waving()
    noisy, repaired = spoilt(truth)
    page = page_of(tmp_path, [("truth", truth), ("noisy", noisy)], repaired=repaired, facts={"model": "m.mend"})
    counts = repaired.counts()
    for word, key in (("measured", "measured"), ("filled", "filled"), ("left open", "left_open")):
        assert f"{counts[key]:,} {word}" in page.shown
    assert "Most changed markers from noisy to repaired" in page.shown
    jumps = [a for _, a in page.tags if a.get("class") == "jump" and "data-frame" in a]
    assert (jumps[0]["data-channel"], jumps[0]["data-recording"]) == ("3", "2")
    assert jumps[0]["data-frame"] in ("10", "30")
    assert "one <gap>" in page.shown
    assert "m.mend" in page.shown
    # marker D: 2 repaired, 0 filled, 0 open, 238 measured
    row = page.text[page.text.index("<details") :].split("<tr>")[5]
    assert re.findall(r">(\d+)</td>", row)[-4:] == ["2", "0", "0", "238"]


def test_the_table_of_changes_takes_no_room_for_zeros_and_says_metres_where_it_is_metres(tmp_path):
    truth = waving()
    fallen = truth.positions.copy()
    fallen[10:, 3, 2] -= 3.08
    fallen[20, 1, 2] += 0.03
    page = page_of(tmp_path, [("truth", truth), ("fallen", truth.with_positions(fallen))])
    changed = page.text[page.text.index("Most changed") : page.text.index("<details")]
    assert re.findall(r"<th scope=col>(\w+)</th>", changed) == ["name", "RMS", "largest"]
    assert "3.08 m<" in changed
    assert "30 mm<" in changed
    assert "e+" not in changed


def test_what_was_repaired_is_found_by_its_gaps_and_keeps_its_colour(tmp_path):
    truth = waving()
    noisy, repaired = spoilt(truth)
    listed = [("noisy", noisy), ("truth", truth), ("mended", repaired.recording)]
    blocks = page_of(tmp_path, listed, repaired=repaired).data["recordings"]
    assert [b["before"] for b in blocks] == [True, False, False]
    assert [b["repaired"] for b in blocks] == [False, False, True]
    assert [b["colour"] for b in blocks] == [1, 2, 0]


def test_a_repair_not_listed_is_added_and_one_recording_is_enough(tmp_path):
    truth = waving()
    noisy, repaired = spoilt(truth)
    added = page_of(tmp_path, [("noisy", noisy)], repaired=repaired).data
    assert [b["name"] for b in added["recordings"]] == ["noisy", "repaired"]
    assert added["reference"] == 1
    alone = page_of(tmp_path, [("take", noisy)])
    state = unpack_bytes(alone.data["recordings"][0]["state"])
    assert np.array_equal(state == Origin.LEFT_OPEN, ~noisy.present)
    assert "missing" in alone.shown
    assert alone.data["recordings"][0]["std"] is None


def test_a_long_recording_is_thinned_and_the_page_says_so_but_no_repair_is_lost(tmp_path):
    truth = waving(frames=4001, fps=240.0)
    noisy, repaired = spoilt(truth)
    page = page_of(tmp_path, [("noisy", noisy)], repaired=repaired)
    block = page.data["recordings"][1]
    assert block["stride"] == 4
    assert block["frames"] == 4001
    assert block["positions"]["shape"] == [1001, 15]
    state = unpack_bytes(block["state"])
    assert state[10 // 4, 3] == Origin.REPAIRED  # frame 10 itself is not drawn
    assert state.shape == (1001, 5)
    assert "one frame in 4, 60 a second" in page.shown
    wanted = repaired.recording.positions[::4].reshape(1001, -1)
    assert np.nanmax(np.abs(unpack(block["positions"]) - wanted) / block["positions"]["step"]) <= 0.5001
    short = page_of(tmp_path, [("take", waving(frames=3600, fps=240.0))])
    assert short.data["recordings"][0]["stride"] == 1
    assert "one frame in" not in short.shown


def test_every_up_axis_turns_to_the_page_s_own(tmp_path):
    for up in ([0, 0, 1.0], [0, 1.0, 0], [1.0, 0, 0], [0, -1.0, 0], [0.6, 0, 0.8]):
        view = np.array(page_of(tmp_path, [("take", waving(up=up))]).data["recordings"][0]["view"])
        assert view @ up == pytest.approx([0, 0, 1])
        assert view @ view.T == pytest.approx(np.eye(3), abs=1e-8)
        assert np.linalg.det(view) == pytest.approx(1)


def test_markers_of_one_set_share_their_lines(tmp_path):
    truth = waving()
    noisy, repaired = spoilt(truth)
    other = waving(names=("P", "Q"))
    blocks = page_of(tmp_path, [("noisy", noisy), ("other", other)], repaired=repaired).data["recordings"]
    assert blocks[0]["lines"] == blocks[2]["lines"]
    assert blocks[2]["lines"]
    assert max(max(pair) for pair in blocks[1]["lines"]) < 2


def test_the_same_input_gives_the_same_bytes(tmp_path):
    noisy, repaired = spoilt(arm())
    for name in ("a.html", "b.html"):
        html_report(tmp_path / name, [("noisy", noisy)], repaired=repaired, facts={"model": "m"})
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_a_thousand_frames_of_two_bodies_take_about_half_a_megabyte(tmp_path):
    rng = np.random.default_rng(0)
    joints = 31
    t = np.arange(1000)[:, None, None] / 120
    clean = np.sin(t * (1 + np.arange(3)) + np.arange(joints)[:, None] * 0.3) * 0.4 + [0, 0, 1]
    names = tuple(f"M{j}" for j in range(joints))
    noisy = Markers(names, clean + rng.normal(0, 0.01, clean.shape), 120.0)
    html_report(tmp_path / "r.html", [("noisy", noisy), ("clean", Markers(names, clean, 120.0))])
    assert (tmp_path / "r.html").stat().st_size < 420_000


def test_nothing_to_show_is_said_in_one_line(tmp_path):
    with pytest.raises(UsageError, match="at least one recording"):
        html_report(tmp_path / "r.html", [])
    with pytest.raises(UsageError, match="'empty' has none"):
        html_report(tmp_path / "r.html", [("empty", waving(frames=0))])
    with pytest.raises(FileError, match="no folder"):
        html_report(tmp_path / "nowhere" / "r.html", [("take", waving())])
    assert not list(tmp_path.iterdir())


def test_a_recording_without_a_single_sample_and_one_of_one_frame(tmp_path):
    nothing = waving().with_positions(np.full((240, 5, 3), np.nan))
    assert page_of(tmp_path, [("nothing", nothing)]).data["ground"] == 0.0
    assert page_of(tmp_path, [("still", waving(frames=1))]).data["recordings"][0]["frames"] == 1


@pytest.mark.parametrize(("subjects", "shown"), [("aa", ("LWRA", "RWRA")), ("ab", ("a:LWRA", "b:RWRA"))])
def test_the_subject_all_markers_share_takes_no_room_in_the_tables(tmp_path, subjects, shown):
    names = tuple(f"{subject}:{bare}" for subject, bare in zip(subjects, ("LWRA", "RWRA"), strict=True))
    places = np.random.default_rng(0).normal(size=(20, 2, 3))
    page = page_of(tmp_path, [("take", Markers(names, places, 60.0))])
    assert all(f">{name}</button>" in page.text for name in shown)


def test_what_may_be_wrong_with_a_file_stands_among_the_warnings_once_with_its_names():
    doubted = replace(arm(), warnings=("the file is <cut off>",))
    _, repaired = spoilt(doubted)
    card = warnings_card([("one", doubted), ("other", doubted)], repaired)
    assert card.count("the file is &lt;cut off&gt;") == 1
    assert "one, other" in card
    assert "one &lt;gap&gt;" in card
    assert warnings_card([("clean", arm())], None) == ""


def test_recordings_whose_times_are_rounded_otherwise_are_compared(tmp_path):
    clip = waving(fps=30.000000000000007)
    for fps, compared in ((30.0000003, True), (60.0, False)):
        html_report(tmp_path / "page.html", [("sensed", clip), ("corrected", replace(clip, fps=fps))])
        assert ("Most changed" in (tmp_path / "page.html").read_text("utf-8")) == compared
