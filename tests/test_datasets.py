"""Public recordings by name, from a server of our own: what is right is kept, what is not is told and left out."""

import hashlib
import http.server
import json
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from motionmend import datasets
from motionmend.cli import main
from motionmend.datasets import DATASETS, Dataset, Item, fetch, named, sha256_of
from motionmend.errors import FileError, UsageError

CONTENT = {"a.csv": b"time,x\n0,1\n", "deep/b.bin": bytes(range(256)) * 300}


class Server(http.server.ThreadingHTTPServer):
    """Gives out CONTENT and counts how often it was asked."""

    asked = 0


@pytest.fixture
def server() -> Iterator[Server]:
    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            found.asked += 1
            body = CONTENT.get(self.path.lstrip("/"))
            if self.path == "/broken":  # off in the midst of a piece, as where a proxy gives up
                self.wfile.write(b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nff\r\ntime,x")
                return
            if self.path == "/other":
                self.wfile.write(b"220 another kind of server\r\n")
                return
            self.send_response(404 if body is None else 200)
            self.send_header("Content-Length", str(len(body or b"")))
            self.end_headers()
            self.wfile.write(body or b"")

        def log_message(self, *arguments: object) -> None:
            pass

    found = Server(("127.0.0.1", 0), Handler)
    thread = threading.Thread(target=found.serve_forever, daemon=True)
    thread.start()
    yield found
    found.shutdown()
    thread.join()
    found.server_close()


def public(server: Server, **wrong: str) -> Dataset:
    """The content as a data set; `wrong` gives another hash to a file by its stem."""
    items = tuple(
        Item(
            path,
            f"http://127.0.0.1:{server.server_address[1]}/{path}",
            wrong.get(Path(path).stem, hashlib.sha256(body).hexdigest()),
            len(body),
        )
        for path, body in CONTENT.items()
    )
    return Dataset("ours", "two files", "nobody", "none", items)


def test_files_are_fetched_once_and_again_when_they_were_changed(server: Server, tmp_path: Path) -> None:
    one = public(server)
    files = fetch(one, tmp_path)
    assert [file.read_bytes() for file in files] == list(CONTENT.values())
    assert files == [tmp_path / "ours" / path for path in CONTENT]
    assert fetch(one, tmp_path) == files
    assert server.asked == 2
    files[1].write_bytes(b"changed")
    fetch(one, tmp_path)
    assert server.asked == 3
    assert sha256_of(files[1]) == one.items[1].sha256


def test_another_content_is_not_kept(server: Server, tmp_path: Path) -> None:
    with pytest.raises(FileError, match=r"b\.bin.*not kept"):
        fetch(public(server, b="0" * 64), tmp_path)
    assert {file.name for file in tmp_path.rglob("*") if file.is_file()} == {"a.csv"}


def test_what_is_not_there_is_one_line(server: Server, tmp_path: Path) -> None:
    gone = Item("c.csv", f"http://127.0.0.1:{server.server_address[1]}/c.csv", "0" * 64, 3)
    with pytest.raises(FileError, match="cannot be fetched"):
        fetch(Dataset("ours", "", "", "", (gone,)), tmp_path)
    nobody = Item("c.csv", "http://127.0.0.1:9/c.csv", "0" * 64, 3)
    with pytest.raises(FileError, match="cannot be fetched"):
        fetch(Dataset("ours", "", "", "", (nobody,)), tmp_path)
    for path in ("broken", "other"):
        odd = Item("c.csv", f"http://127.0.0.1:{server.server_address[1]}/{path}", "0" * 64, 3)
        with pytest.raises(FileError, match="cannot be fetched"):
            fetch(Dataset("ours", "", "", "", (odd,)), tmp_path)
    assert [file for file in tmp_path.rglob("*") if file.is_file()] == []


def test_the_command_lists_fetches_and_refuses(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(datasets, "DATASETS", (public(server), public(server, a="1" * 64)))
    monkeypatch.setattr(datasets.named, "__defaults__", ((public(server),),))
    assert main(["data", "list", "--json"]) == 0
    assert [json.loads(line)["files"] for line in capsys.readouterr().out.splitlines()] == [2, 2]
    assert main(["data", "get", "ours", "--dir", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["name"] == "ours"
    assert (tmp_path / "ours" / "a.csv").read_bytes() == CONTENT["a.csv"]
    assert main(["data", "get", "nothing", "--dir", str(tmp_path)]) == 2
    assert main(["data", "get"]) == 2
    assert main(["data", "get", "ours", "--dir", str(tmp_path / "ours" / "a.csv")]) == 1


def test_the_list_is_sound() -> None:
    assert len({one.name for one in DATASETS}) == len(DATASETS)
    for one in DATASETS:
        assert one.terms
        assert one.source
        for item in one.items:
            assert item.url.startswith("https://")
            assert len(bytes.fromhex(item.sha256)) == 32
            assert ".." not in Path(item.path).parts
            assert not Path(item.path).is_absolute()
    with pytest.raises(UsageError):
        named("nothing")


def test_hashes_are_those_of_the_recordings_at_hand(data: Path) -> None:
    folders = {"laban-gestures": data / "kinect" / "laban", "uiprmd-squats": data / "kinect" / "uiprmd"}
    for one in DATASETS:
        for item in one.items:
            file = folders[one.name] / item.path
            if not file.is_file():
                pytest.skip(f"no {item.path} in MOTIONMEND_DATA")
            assert (sha256_of(file), file.stat().st_size) == (item.sha256, item.size)
