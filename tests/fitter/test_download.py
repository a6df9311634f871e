"""Downloads of public data, against a local server that fails on demand."""

from __future__ import annotations

import dataclasses
import hashlib
import io
import os
import pathlib
import tomllib
import urllib.parse
import zipfile

import pytest
from data_server import DataServer

from brdf.errors import FileError, UserError
from fitter import datasets
from fitter.datasets.catalogue import catalogue, data_folder, find, matching
from fitter.datasets.download import fetch

MERL = find("chrome")
CONTENT = MERL.magic + bytes(range(256)) * 800
CHROME = dataclasses.replace(MERL, size=len(CONTENT))
SHA256 = hashlib.sha256(CONTENT).hexdigest()


@pytest.fixture
def server():
    running = DataServer()
    yield running
    running.close()


@pytest.fixture(autouse=True)
def _direct(monkeypatch):
    for name in ("http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.delenv(name, raising=False)


def get(entry, folder, server, **more):
    return fetch(entry, folder, server.url, wait=0.01, **more)


def everything(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


def test_the_catalogue_has_the_published_numbers_of_materials():
    # Oracle: the two databases' own counts, 100 and 62 (RGL's twice: RGB and spectral).
    entries = catalogue().values()
    assert sum(entry.group == "merl" and not entry.members for entry in entries) == 100
    assert sum(entry.group == "rgl" for entry in entries) == 2 * 62
    assert len(catalogue()["merl"].members) == 100


def test_every_entry_is_complete_and_every_checksum_belongs_to_one():
    files = [entry.file for entry in catalogue().values()]
    assert len(set(files)) == len(files)
    for entry in catalogue().values():
        assert urllib.parse.urlparse(entry.url).scheme == "https"
        assert entry.url.endswith("/" + entry.file)
        assert entry.licence
        assert entry.notice
        kind, _, digest = (entry.checksum or "sha256:" + "0" * 64).partition(":")
        assert len(bytes.fromhex(digest)) == hashlib.new(kind).digest_size
    listed = tomllib.loads((pathlib.Path(datasets.__file__).parent / "datasets.toml").read_text())
    assert set(listed["rgl"]["checksums"]) <= set(files)


def test_recorded_checksums_are_those_of_the_real_files(shared):
    # Oracle: the measured files themselves.
    for path in sorted((shared / "data" / "rgl_bsdf").glob("*.bsdf")):
        assert find(path.name).checksum == "sha256:" + hashlib.sha256(path.read_bytes()).hexdigest()
        assert path.read_bytes().startswith(find(path.name).magic)


@pytest.mark.parametrize(
    ("name", "file"),
    [
        ("chrome", "chrome.binary"),
        ("merl/Chrome.binary", "chrome.binary"),
        ("chm_mint", "chm_mint_rgb.bsdf"),
        ("chm-mint", "chm_mint_rgb.bsdf"),
        ("chm_mint_spec.bsdf", "chm_mint_spec.bsdf"),
        ("gold_paint", "gold-paint.binary"),
    ],
)
def test_names_are_found_as_people_write_them(name, file):
    assert find(name).file == file


@pytest.mark.parametrize(
    ("name", "near"), [("crome", "`chrome`"), ("gold", "`gold-paint`"), ("", "225"), ("x y", "225")]
)
def test_an_unknown_name_names_the_nearest(name, near):
    if name == "gold":
        near = "gold-metallic-paint"
    with pytest.raises(UserError, match=near):
        find(name)


def test_patterns_match_names_and_groups():
    assert {entry.name for entry in matching("*_spec")} == {e.name for e in matching("rgl") if e.name.endswith("_spec")}
    assert [entry.name for entry in matching("chrome")] == ["chrome-steel", "chrome"]
    assert len(matching("")) == len(catalogue())
    assert matching("unobtainium") == []


def test_the_folder_is_the_chosen_one_then_the_variable_then_the_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("BRDF_DATA", str(tmp_path))
    assert data_folder("here").name == "here"
    assert data_folder() == tmp_path
    monkeypatch.delenv("BRDF_DATA")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert "brdf-fitter" in str(data_folder())


def test_a_download_arrives_with_its_sha256_and_is_not_repeated(server, tmp_path):
    # Oracle: hashlib on what the server sent.
    server.files["chrome.binary"] = CONTENT
    (path,) = get(CHROME, tmp_path, server)
    assert path.read_bytes() == CONTENT
    assert (tmp_path / "merl" / "chrome.binary.sha256").read_text() == f"{SHA256}  chrome.binary\n"
    assert everything(tmp_path) == ["merl/chrome.binary", "merl/chrome.binary.sha256"]
    mask = os.umask(0)
    os.umask(mask)
    assert path.stat().st_mode & 0o777 == 0o666 & ~mask
    assert get(CHROME, tmp_path, server) == [path]
    assert server.requests == ["chrome.binary"]


def test_a_changed_file_is_told_and_force_brings_it_back(server, tmp_path):
    server.files["chrome.binary"] = CONTENT
    (path,) = get(CHROME, tmp_path, server)
    path.write_bytes(CONTENT[:-1] + b"x")
    with pytest.raises(FileError, match=r"has changed.*--force"):
        get(CHROME, tmp_path, server)
    assert get(CHROME, tmp_path, server, force=True) == [path]
    assert path.read_bytes() == CONTENT


def test_a_file_put_there_by_hand_is_accepted_only_if_it_is_one(server, tmp_path):
    (tmp_path / "merl").mkdir()
    path = tmp_path / "merl" / "chrome.binary"
    path.write_bytes(CONTENT[:-1])
    with pytest.raises(FileError, match=f"{len(CONTENT) - 1} bytes"):
        get(CHROME, tmp_path, server)
    path.write_bytes(CONTENT)
    assert get(CHROME, tmp_path, server) == [path]
    assert (tmp_path / "merl" / "chrome.binary.sha256").read_text().startswith(SHA256)
    assert server.requests == []


@pytest.mark.parametrize("fault", ["cut", "page", 503, 429])
def test_what_may_pass_is_tried_again(fault, server, tmp_path):
    server.files["chrome.binary"] = CONTENT
    server.faults["chrome.binary"] = [fault, fault]
    said = []
    (path,) = get(CHROME, tmp_path, server, say=said.append)
    assert path.read_bytes() == CONTENT
    assert len(server.requests) == 3
    assert "attempt 3 of 3" in said[-1]


@pytest.mark.parametrize(
    ("fault", "message", "attempts"),
    [
        ("cut", "broke off", 3),
        ("page", "something else than chrome.binary", 3),
        (503, "HTTP 503", 3),
        (404, "HTTP 404.*brdf data get merl", 1),
        (403, "HTTP 403", 1),
    ],
)
def test_a_failure_is_named_and_leaves_nothing(fault, message, attempts, server, tmp_path):
    server.files["chrome.binary"] = CONTENT
    server.faults["chrome.binary"] = [fault] * 9
    with pytest.raises(FileError, match=message):
        get(CHROME, tmp_path, server)
    assert len(server.requests) == attempts
    assert everything(tmp_path) == []


def test_a_file_of_another_length_is_refused(server, tmp_path):
    server.files["chrome.binary"] = CONTENT + b"more"
    with pytest.raises(FileError, match=f"gave {len(CONTENT) + 4} bytes"):
        get(CHROME, tmp_path, server)
    assert everything(tmp_path) == []


def test_a_wrong_checksum_is_refused(server, tmp_path):
    server.files["chrome.binary"] = CONTENT
    wrong = dataclasses.replace(CHROME, checksum="sha256:" + "0" * 64)
    with pytest.raises(FileError, match=f"{SHA256}; the catalogue says 0000"):
        get(wrong, tmp_path, server)
    assert everything(tmp_path) == []


def test_a_failed_replacement_keeps_the_old_file(server, tmp_path):
    server.files["chrome.binary"] = CONTENT
    (path,) = get(CHROME, tmp_path, server)
    server.faults["chrome.binary"] = ["cut"] * 3
    with pytest.raises(FileError, match="broke off"):
        get(CHROME, tmp_path, server, force=True)
    assert path.read_bytes() == CONTENT


def test_no_server_means_offline(server, tmp_path):
    server.close()
    with pytest.raises(FileError, match=r"cannot be reached \(Connection refused\).*offline") as caught:
        get(CHROME, tmp_path, server)
    assert str(tmp_path / "merl" / "chrome.binary") in str(caught.value)
    assert everything(tmp_path) == []


def test_an_interrupted_transfer_leaves_nothing(server, tmp_path):
    class Interrupting:
        total = 0

        def update(self, count):
            raise KeyboardInterrupt

        def reset(self): ...

        def close(self): ...

    server.files["chrome.binary"] = CONTENT
    with pytest.raises(KeyboardInterrupt):
        get(CHROME, tmp_path, server, bar=Interrupting())
    assert everything(tmp_path) == []


def archive(names, damage=False):
    """A small MERL archive and its entry, with the MD5 of the archive as it is served."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as zipped:
        for name in names:
            zipped.writestr(f"BRDFDatabase/brdfs/{name}.binary", CONTENT + name.encode())
    data = content.getvalue()
    if damage:
        data = data.replace(CONTENT[-100:] + b"brass", CONTENT[-99:] + b"brass!"[:6])
    members = tuple(dataclasses.replace(find(name), size=None) for name in ("chrome", "brass"))
    whole = catalogue()["merl"]
    checksum = "md5:" + hashlib.md5(data).hexdigest()
    return data, dataclasses.replace(whole, size=len(data), checksum=checksum, members=members)


def test_an_archive_is_checked_unpacked_and_removed(server, tmp_path):
    server.files["BRDFDatabase.zip"], whole = archive(["chrome", "brass", "steel"])
    paths = get(whole, tmp_path, server)
    assert [path.read_bytes() for path in paths] == [CONTENT + b"chrome", CONTENT + b"brass"]
    assert everything(tmp_path / "merl") == [
        "brass.binary",
        "brass.binary.sha256",
        "chrome.binary",
        "chrome.binary.sha256",
    ]
    assert get(whole, tmp_path, server) == paths
    assert len(server.requests) == 1


@pytest.mark.parametrize("names", [["chrome"], None])
def test_an_archive_that_lacks_a_file_or_is_damaged_is_told(names, server, tmp_path):
    data, whole = archive(names or ["chrome", "brass"], damage=names is None)
    server.files["BRDFDatabase.zip"] = data
    with pytest.raises(FileError, match="is not the archive"):
        get(whole, tmp_path, server)
    assert "merl/brass.binary" not in everything(tmp_path)


def test_a_folder_that_cannot_be_made_is_named(server, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="cannot be made a folder"):
        get(CHROME, tmp_path / "file", server)


def test_a_mirror_that_is_no_address_is_named(tmp_path):
    with pytest.raises(FileError, match="not a web address"):
        fetch(CHROME, tmp_path, "mirror")
