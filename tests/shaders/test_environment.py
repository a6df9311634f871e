"""Environment files in: real ones, hand-made ones in every orientation and coding, broken ones."""

from __future__ import annotations

import pathlib

import numpy as np
import OpenEXR
import pytest

import brdf
from shaders import Environment, load_environment, write_exr
from shaders.radiance_hdr import read_hdr

_HDRI = pathlib.Path(__file__).parents[3] / "shared" / "data" / "hdri"
ORIENTATIONS = ["-Y +X", "-Y -X", "+Y +X", "+Y -X", "+X -Y", "+X +Y", "-X -Y", "-X +Y"]


def _rgbe(seed: int, height: int, width: int) -> np.ndarray:
    rgbe = np.random.default_rng(seed).integers(2, 255, (height, width, 4), dtype=np.uint8)
    rgbe[..., 3] = 120 + rgbe[..., 3] % 20
    rgbe[:, : width // 2] = rgbe[:, :1]  # runs
    return rgbe


def _values(rgbe: np.ndarray) -> np.ndarray:
    """The definition: mantissa times 2^(exponent - 136)."""
    return rgbe[..., :3].astype(np.float64) * 2.0 ** (rgbe[..., 3:].astype(np.float64) - 136)


def _file(path: pathlib.Path, resolution: str, body: bytes, header: str = "FORMAT=32-bit_rle_rgbe\n") -> pathlib.Path:
    path.write_bytes(f"#?RADIANCE\n{header}\n{resolution}\n".encode() + body)
    return path


def _new_line(line: np.ndarray) -> bytes:
    """A scan line in new run lengths: runs where there are any, literals elsewhere."""
    coded = bytes([2, 2, len(line) >> 8, len(line) & 255])
    for component in line.T:
        start = 0
        while start < len(component):
            run = 1
            while start + run < len(component) and run < 127 and component[start + run] == component[start]:
                run += 1
            coded += bytes([128 + run, component[start]]) if run > 1 else bytes([1, component[start]])
            start += run
    return coded


def _old_line(line: np.ndarray) -> bytes:
    """A scan line in old run lengths."""
    coded, start = b"", 0
    while start < len(line):
        run = 1
        while start + run < len(line) and (line[start + run] == line[start]).all():
            run += 1
        coded += line[start].tobytes()
        left, repeats = run - 1, b""
        while left:
            repeats += bytes([1, 1, 1, left & 255])
            left >>= 8
        coded += repeats
        start += run
    return coded


@pytest.mark.parametrize("code", [_new_line, _old_line, lambda line: line.tobytes()], ids=["new", "old", "flat"])
def test_every_coding_of_a_hdr_gives_its_values(tmp_path: pathlib.Path, code):
    rgbe = _rgbe(1, 300, 600)
    path = _file(tmp_path / "a.hdr", "-Y 300 +X 600", b"".join(code(line) for line in rgbe))
    np.testing.assert_array_equal(read_hdr(path, 1024), _values(rgbe))


@pytest.mark.parametrize("signs", ORIENTATIONS)
def test_every_orientation_of_a_hdr_is_turned_upright(tmp_path: pathlib.Path, signs: str):
    upright = _rgbe(2, 9, 18)
    first, second = signs.split()
    # Y grows upwards and X to the right: "-Y +X" is the order of reading.
    stored = upright[:, ::-1] if "-X" in signs else upright
    stored = stored[::-1] if "+Y" in signs else stored
    stored = stored.transpose(1, 0, 2) if first.endswith("X") else stored
    resolution = f"{first} {stored.shape[0]} {second} {stored.shape[1]}"
    path = _file(tmp_path / "a.hdr", resolution, np.ascontiguousarray(stored).tobytes())
    np.testing.assert_array_equal(read_hdr(path, 1024), _values(upright))


def test_the_exposure_of_a_hdr_is_taken_out(tmp_path: pathlib.Path):
    rgbe = _rgbe(3, 2, 4)
    header = "FORMAT=32-bit_rle_rgbe\nEXPOSURE=2.0\nEXPOSURE=4\n"
    path = _file(tmp_path / "a.hdr", "-Y 2 +X 4", rgbe.tobytes(), header)
    np.testing.assert_array_equal(read_hdr(path, 1024), _values(rgbe) / 8)


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        (b"", "begins with"),
        (b"\x89PNG\r\n\x1a\n", "begins with"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n" + b"#" * 70000, "No empty line"),
        (b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 2 +X 4\n" + bytes(32), "32-bit_rle_xyze"),
        (b"#?RADIANCE\nEXPOSURE=nan\n\n-Y 2 +X 4\n" + bytes(32), "EXPOSURE=nan"),
        (b"#?RADIANCE\nEXPOSURE=1e-50\n\n-Y 2 +X 4\n" + bytes(32), "`1e-50`, is outside"),
        (b"#?RADIANCE\nEXPOSURE=1e20\nEXPOSURE=1e20\n\n-Y 2 +X 4\n" + bytes(32), "`1e\\+40`, is outside"),
        (b"#?RADIANCE\n\n-Y 2 +Y 4\n" + bytes(32), "resolution line"),
        (b"#?RADIANCE\n\nhello\n" + bytes(32), "resolution line"),
        (b"#?RADIANCE\n\n-Y 999999999 +X 999999999\n" + bytes(32), "outside 1 to 16384"),
        (b"#?RADIANCE\n\n-Y 0 +X 4\n", "outside 1 to 16384"),
        (b"#?RADIANCE\n\n-Y 8192 +X 16384\n" + bytes(32), "ends inside the pixels"),
        (b"#?RADIANCE\n\n-Y 2 +X 4\n" + bytes(31), "ends inside the pixels"),
        (b"#?RADIANCE\n\n-Y 1 +X 9\n\x02\x02\x00\x08" + bytes(64), "should have 9"),
        (b"#?RADIANCE\n\n-Y 1 +X 9\n\x02\x02\x00\x09\x8a\x01" + bytes(64), "do not add up"),
        (b"#?RADIANCE\n\n-Y 1 +X 9\n\x02\x02\x00\x09\x00\x01" + bytes(64), "do not add up"),
        (b"#?RADIANCE\n\n-Y 1 +X 2\n\x01\x01\x01\x09" + bytes(8), "do not add up"),
    ],
)
def test_a_broken_hdr_is_refused_by_file_and_place(tmp_path: pathlib.Path, content: bytes, complaint: str):
    path = tmp_path / "broken.hdr"
    path.write_bytes(content)
    with pytest.raises(brdf.FileError, match=complaint) as raised:
        load_environment(path)
    assert raised.value.path == str(path)
    assert raised.value.remedy


@pytest.mark.parametrize("name", ["lebombo_1k.hdr", "studio_small_03_1k.hdr", "venice_sunset_1k.hdr"])
def test_a_real_hdr_is_read(name: str):
    if not (_HDRI / name).exists():
        pytest.skip("the shared pictures are not beside this checkout")
    environment = load_environment(_HDRI / name)
    assert environment.pixels.shape == (512, 1024, 3)
    assert environment.clamped == 0
    # Every value of RGBE is a whole number of steps of its pixel's largest component's 2^-8.
    assert 0 < environment.pixels.mean() < environment.pixels.max()


def _write_exr(path: pathlib.Path, channels: dict[str, np.ndarray]) -> pathlib.Path:
    OpenEXR.File({}, {name: np.ascontiguousarray(plane) for name, plane in channels.items()}).write(str(path))
    return path


@pytest.mark.parametrize("dtype", [np.float16, np.float32])
@pytest.mark.parametrize("names", ["RGB", "RGBA"])
def test_colour_of_an_exr_is_read(tmp_path: pathlib.Path, dtype: type, names: str):
    planes = {name: np.random.default_rng(4).random((8, 16)).astype(dtype) * (k + 1) for k, name in enumerate(names)}
    environment = load_environment(_write_exr(tmp_path / "a.exr", planes))
    np.testing.assert_array_equal(environment.pixels, np.stack([planes[name] for name in "RGB"], axis=-1))


def test_luminance_of_an_exr_is_read_as_grey(tmp_path: pathlib.Path):
    plane = np.random.default_rng(5).random((8, 16)).astype(np.float32)
    pixels = load_environment(_write_exr(tmp_path / "a.exr", {"Y": plane})).pixels
    np.testing.assert_array_equal(pixels, np.repeat(plane[..., None], 3, axis=-1))


def test_values_that_are_no_light_are_clamped_and_counted(tmp_path: pathlib.Path):
    pixels = np.ones((8, 16, 3), np.float32)
    pixels[0, 0], pixels[1, 2, 0], pixels[3, 4, 1] = [-1, np.nan, np.inf], -np.inf, -3894
    write_exr(tmp_path / "a.exr", pixels)
    environment = load_environment(tmp_path / "a.exr")
    assert environment.clamped == 5
    assert environment.pixels[0, 0].tolist() == [0, 0, 65504]
    assert np.isfinite(environment.pixels).all()
    assert environment.pixels.min() == 0


def test_a_written_exr_reads_back_equal_whatever_its_memory_order(tmp_path: pathlib.Path):
    pixels = np.random.default_rng(6).random((16, 8, 4)).astype(np.float64)
    write_exr(tmp_path / "a.exr", pixels.transpose(1, 0, 2)[::-1, :, :3])
    expected = pixels.transpose(1, 0, 2)[::-1, :, :3].astype(np.float32)
    np.testing.assert_array_equal(load_environment(tmp_path / "a.exr").pixels, expected)


def test_a_broken_exr_is_refused(tmp_path: pathlib.Path):
    good = tmp_path / "good.exr"
    write_exr(good, np.random.default_rng(7).random((64, 128, 3)))
    for name, content in (
        ("empty", b""),
        ("magic", b"#?RADIANCE\n\n"),
        ("header", good.read_bytes()[:40]),
        ("cut", good.read_bytes()[:5000]),
    ):
        path = tmp_path / f"{name}.exr"
        path.write_bytes(content)
        with pytest.raises(brdf.FileError, match=f"{name}.exr"):
            load_environment(path)


def test_an_exr_without_colour_is_refused_naming_its_channels(tmp_path: pathlib.Path):
    path = _write_exr(tmp_path / "z.exr", {"Z": np.zeros((8, 16), np.float32)})
    with pytest.raises(brdf.FileError, match="channels `Z`"):
        load_environment(path)


def test_a_picture_of_another_shape_is_refused(tmp_path: pathlib.Path):
    write_exr(tmp_path / "a.exr", np.ones((16, 16, 3)))
    with pytest.raises(brdf.FileError, match="twice as wide as high"):
        load_environment(tmp_path / "a.exr")


def test_an_unknown_name_is_answered_with_the_nearest(tmp_path: pathlib.Path):
    with pytest.raises(brdf.UserError, match="Did you mean `studio`"):
        load_environment("studo")
    with pytest.raises(brdf.FileError, match="cannot be read"):
        load_environment(tmp_path / "absent.hdr")


def test_light_beyond_every_sun_is_clamped_and_counted_and_suns_are_kept(tmp_path: pathlib.Path):
    pixels = np.ones((8, 16, 3), np.float32)
    pixels[1, 2], pixels[2, 3], pixels[3, 4] = 3.4e38, [1e5, 1e6, 1.6e9], [2e10, 0, 1e10]
    write_exr(tmp_path / "a.exr", pixels)
    environment = load_environment(tmp_path / "a.exr")
    assert environment.clamped == 4
    np.testing.assert_array_equal(environment.pixels[1, 2], np.float32(1e10))
    np.testing.assert_array_equal(environment.pixels[2, 3], np.float32([1e5, 1e6, 1.6e9]))
    np.testing.assert_array_equal(environment.pixels[3, 4], np.float32([1e10, 0, 1e10]))


def test_a_hdr_whose_exposure_takes_it_beyond_float32_is_clamped_and_counted(tmp_path: pathlib.Path):
    bright = np.full((2, 4, 4), 255, np.uint8)
    path = _file(tmp_path / "a.hdr", "-Y 2 +X 4", bright.tobytes(), "EXPOSURE=1e-6\n")
    environment = load_environment(path)
    assert environment.clamped == bright[..., :3].size
    assert np.isfinite(environment.pixels).all()


@pytest.mark.parametrize("shape", [(1, 1), (1, 2), (1, 3), (3, 5), (3, 7)])
def test_a_picture_of_a_few_texels_or_an_odd_size_is_read(tmp_path: pathlib.Path, shape: tuple[int, int]):
    pixels = np.random.default_rng(8).random((*shape, 3), np.float32)
    write_exr(tmp_path / "a.exr", pixels)
    np.testing.assert_array_equal(load_environment(tmp_path / "a.exr").pixels, pixels)


def test_the_digest_is_of_shape_and_values_alone():
    pixels = np.random.default_rng(9).random((4, 8, 3), np.float32)
    first = Environment(pixels, "first")
    assert Environment(pixels.copy(), "second", 3).digest == first.digest
    assert Environment(np.ascontiguousarray(pixels[:, ::-1])[:, ::-1], "same values").digest == first.digest
    changed = pixels.copy()
    changed[3, 7, 2] = np.nextafter(changed[3, 7, 2], np.float32(2))
    others = {Environment(one, "other").digest for one in (changed, pixels.reshape(8, 4, 3), pixels[:, ::-1])}
    assert len(others | {first.digest}) == 4
    # Equality stays identity.
    assert Environment(pixels, "first") != first


def test_of_a_damaged_picture_only_the_error_is_told(tmp_path: pathlib.Path, capfd: pytest.CaptureFixture[str]):
    # OpenEXR itself prints to both, and results for machines go to stdout.
    whole = _write_exr(tmp_path / "a.exr", {name: np.ones((64, 128), np.float32) for name in "RGB"})
    whole.write_bytes(whole.read_bytes()[:-100])
    with pytest.raises(brdf.FileError, match="damaged or cut off"):
        load_environment(whole)
    assert capfd.readouterr() == ("", "")
