"""Measured metals: from n and k over wavelength to one complex index per channel."""

from __future__ import annotations

import itertools
import json

import click.testing
import numpy as np
import pytest

from brdf.errors import FileError, UserError
from brdf.material import from_dict
from brdf.metals import F0_MAX, METALS, conductor
from fitter import conductor as c
from fitter.cli.main import cli
from fitter.formats._spectrum import rgb_weights

COS = np.cos(np.radians(c.ANGLES_DEG))


def spectrum(n, k) -> c.Spectrum:
    flat = np.ones_like(c.WAVELENGTHS_NM)
    return c.Spectrum(n * flat, k * flat, "a test")


def complex_fresnel(eta, k, cos):
    """Fresnel's amplitudes in complex numbers, averaged over both polarisations; shape (angles, *shape of eta)."""
    eta, k = np.asarray(eta, float), np.asarray(k, float)
    cos = np.reshape(cos, (-1, *(1,) * eta.ndim))
    index = eta + 1j * k
    root = np.sqrt(index**2 - (1 - cos**2))
    amplitudes = (cos - root) / (cos + root), (index**2 * cos - root) / (index**2 * cos + root)
    return sum(np.abs(amplitude) ** 2 for amplitude in amplitudes) / 2


def f0(eta, k):
    return ((eta - 1) ** 2 + k**2) / ((eta + 1) ** 2 + k**2)


def write(tmp_path, text: str | bytes, name="metal.yml"):
    (tmp_path / name).write_bytes(text.encode() if isinstance(text, str) else text)
    return tmp_path / name


def blocks(*blocks: tuple[str, str]) -> str:
    head = "REFERENCES: |\n    A. B. Author, C. van Dyck, E.-F. Third. Title 12. Journal 6, 4370 (1999)\nDATA:\n"
    rows = ["\n".join("        " + row for row in data.splitlines()) for _, data in blocks]
    return head + "".join(f"  - type: {b[0]}\n    data: |\n{r}\n" for b, r in zip(blocks, rows, strict=True))


def test_reflectance_is_that_of_complex_arithmetic_and_of_the_closed_form():
    rng = np.random.default_rng(3)
    eta, k = np.exp(rng.uniform(np.log(1e-3), np.log((10, 20)), (300, 2))).T
    found = c.reflectance(eta, k, COS)
    # 1 - F of the best mirrors is 1e-4 of F: the cancellation costs complex arithmetic four digits.
    np.testing.assert_allclose(found, complex_fresnel(eta, k, COS), atol=1e-12, rtol=1e-9)
    np.testing.assert_allclose(found[0], f0(eta, k), rtol=1e-9)


@pytest.mark.parametrize(
    ("n", "k"), [*itertools.product((0.05, 0.5, 1.5, 3.0, 9.0), (0.5, 2.0, 6.0, 19.0)), (10.0, 1e-3)]
)
def test_an_index_that_is_the_same_at_all_wavelengths_comes_back(n, k):
    found = c.effective_index(spectrum(n, k))
    if f0(n, k) < F0_MAX:
        # The minimum is flat: the place is known to the square root of what the cost is known to.
        np.testing.assert_allclose(found.eta, n, rtol=1e-5)
        np.testing.assert_allclose(found.k, k, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(found.color, f0(n, k), rtol=1e-12)
    assert found.worst.max() < 1e-6


@pytest.mark.parametrize(
    ("n", "k"), [(1e-4, 100.0), (100.0, 1e-6), (1.0, 1e-6), (1e-4, 1e-6), (1e-3, 1e-3), (99.0, 99.0)]
)
def test_extremes_stay_inside_the_bounds_of_the_parameters(n, k):
    found = c.effective_index(spectrum(n, k))
    for value, (low, high) in ((found.eta, c.ETA_BOUNDS), (found.k, c.K_BOUNDS)):
        assert (value >= low * (1 - 1e-12)).all()
        assert (value <= high * (1 + 1e-12)).all()


def test_normal_incidence_is_met_and_no_other_index_of_that_f0_follows_the_metal_better():
    rng = np.random.default_rng(5)
    wavelength = (c.WAVELENGTHS_NM - 360) / 470
    weight = (COS / COS.sum())[:, None]
    for _ in range(6):
        start, end = np.exp(rng.uniform(np.log(0.1), np.log(6), (2, 2)))
        metal = c.Spectrum(*(a + (b - a) * wavelength for a, b in zip(start, end, strict=True)), "a test")
        found = c.effective_index(metal)
        target = (complex_fresnel(metal.n, metal.k, COS) @ c._channel_weights("D65")).clip(0, F0_MAX)
        np.testing.assert_allclose(f0(found.eta, found.k), target[0], rtol=1e-9)
        for channel in range(3):
            # Oracle: all of the circle of constant F0, in 20,000 steps.
            s = (1 + target[0, channel]) / (1 - target[0, channel])
            radius = np.sqrt(s * s - 1)
            eta = np.geomspace(max(1e-3, 1 / (s + radius)), min(10, s + radius), 20_001)[1:-1]
            k = np.sqrt(2 * s * eta - eta**2 - 1)
            eta, k = eta[k < 20], k[k < 20]
            cost = (weight * (complex_fresnel(eta, k, COS) - target[:, channel, None]) ** 2).sum(0)
            assert found.rms[channel] ** 2 <= cost.min() * (1 + 1e-9)
        fit = complex_fresnel(found.eta, found.k, COS)
        np.testing.assert_allclose(found.rms, np.sqrt((weight * (fit - target) ** 2).sum(0)), rtol=1e-6)
        np.testing.assert_allclose(found.worst, np.abs(fit - target).max(0), rtol=1e-6)


def test_a_mirror_is_white_under_every_illuminant():
    for name in ("D65", "a", "E", "FL2"):
        np.testing.assert_allclose(c._channel_weights(name).sum(0), 1, atol=1e-12)
    with pytest.raises(UserError, match="`D66` is not an illuminant"):
        c._channel_weights("D66")


def test_colours_are_those_of_the_spectral_files():
    # Oracle: the reader's own weights, which scale the channels instead of adapting the white. The two whites, of the
    # tables and of Rec. 709, differ by 1e-4.
    theirs, ours = rgb_weights(c.WAVELENGTHS_NM), c._channel_weights("D65")
    rng = np.random.default_rng(7)
    smooth = np.array([np.interp(c.WAVELENGTHS_NM, np.linspace(360, 830, 8), rng.random(8)) for _ in range(50)])
    np.testing.assert_allclose(smooth @ ours, smooth @ theirs, atol=3e-4)


# Linear Rec. 709 at normal incidence as published. `physicallybased`: ../shared/data, three decimals; the second value
# is the tolerance and the third its reason.
ROUNDED = 6e-4
PUBLISHED = {
    "Copper": (ROUNDED, "the same measurement under the same light; illuminant E would give 0.018 more red"),
    "Nickel": (ROUNDED, "the same measurement"),
    "Iron": (ROUNDED, "the same numbers, though it names another page"),
    "Aluminum": (0.012, "Cheng instead of Rakic"),
    "Silver": (0.006, "Babar instead of Johnson"),
    "Gold": (0.06, "Babar instead of Johnson: less absorption in the blue and green"),
}


@pytest.mark.parametrize("name", PUBLISHED)
def test_colours_are_those_of_physicallybased_info(shared, name):
    entries = json.loads((shared / "data" / "physicallybased" / "materials_v1.json").read_text())
    published = next(entry["color"] for entry in entries if entry["name"] == name)
    metal = METALS["aluminium" if name == "Aluminum" else name.lower()]
    np.testing.assert_allclose(metal.color, published, atol=PUBLISHED[name][0])


@pytest.mark.parametrize(
    ("name", "published", "tolerance"),
    [
        ("chromium", (0.549, 0.556, 0.554), 1e-3),
        ("platinum", (0.673, 0.637, 0.585), 7e-3),
        ("copper", (0.955, 0.638, 0.538), 0.025),
        ("aluminium", (0.913, 0.922, 0.924), 7e-3),
        ("gold", (1.022, 0.782, 0.344), 0.06),
    ],
)
def test_colours_are_those_of_real_time_rendering(name, published, tolerance):
    # Oracle: Akenine-Moeller et al. 2018, "Real-Time Rendering", the table of metals' F0. Chromium is the same
    # measurement; the others are other films, and measurements of films differ by the tolerance.
    np.testing.assert_allclose(METALS[name].color, published, atol=tolerance)


@pytest.mark.parametrize("name", METALS)
def test_the_table_is_what_the_measurement_gives(shared, name):
    metal = METALS[name]
    path = shared / "data" / "nk" / (metal.page.removeprefix("main/").replace("/", "-") + ".yml")
    if not path.exists():
        pytest.skip(f"needs {metal.page} of refractiveindex.info, which is not on this machine")
    found = c.effective_index(c.read_spectrum(path))
    # The table has five digits of the index and four decimals of the colour.
    np.testing.assert_allclose(metal.eta, found.eta, rtol=1e-4)
    np.testing.assert_allclose(metal.k, found.k, rtol=1e-4)
    np.testing.assert_allclose(metal.color, found.color, atol=6e-5)
    assert metal.source == found.source


@pytest.mark.parametrize("name", METALS)
def test_the_tables_parts_agree(name):
    metal = METALS[name]
    np.testing.assert_allclose(metal.f0, np.clip(metal.color, 0, F0_MAX), atol=1e-4)
    assert all(c.ETA_BOUNDS[0] <= value <= c.ETA_BOUNDS[1] for value in metal.eta)
    assert all(c.K_BOUNDS[0] <= value <= c.K_BOUNDS[1] for value in metal.k)


def test_a_metal_is_found_by_name_symbol_and_american_spelling():
    assert conductor("gold") == conductor(" Au ") == {"eta": METALS["gold"].eta, "k": METALS["gold"].k}
    assert conductor("Aluminum") == conductor("al")
    with pytest.raises(UserError, match=r"`goldd` is not a metal of the table\. Did you mean `gold`\?"):
        conductor("goldd")


def test_n_and_k_may_stand_in_blocks_of_their_own(tmp_path):
    path = write(tmp_path, blocks(("tabulated n", "0.7 4\n0.4 1\n"), ("tabulated k", "0.39 2\n0.4 2\n0.4 2\n0.71 2")))
    with pytest.raises(FileError, match=r"no row between 0\.4 and 0\.7 um"):
        c.read_spectrum(path)
    n = "\n".join(f"{um:g} {um * 10 - 3:g}" for um in (0.7, 0.4, 0.5, 0.6))
    found = c.read_spectrum(write(tmp_path, blocks(("tabulated n", n), ("tabulated k", n), ("tabulated k", "0.4 1"))))
    # Oracle: a straight line from 1 at 400 nm to 4 at 700 nm, constant beyond.
    expected = ((c.WAVELENGTHS_NM - 400) / 100 + 1).clip(1, 4)
    np.testing.assert_allclose(found.n, expected, atol=1e-12)
    np.testing.assert_allclose(found.k, expected, atol=1e-12)
    assert found.source == "Author et al. 1999"


def test_a_csv_table_is_the_same_metal(tmp_path):
    rows = [(um, 0.2 + um, 3 * um) for um in np.linspace(0.38, 0.72, 9).round(4)]
    yaml = blocks(("tabulated nk", "\n".join(" ".join(map(repr, map(float, row))) for row in rows)))
    a = c.read_spectrum(write(tmp_path, yaml))
    for separator in (",", ";", " \t"):
        lines = ["\ufeff# mine", separator.join(("k", "wavelength_um", "n")), ""]
        lines += [separator.join(map(str, (k, um, n))) for um, n, k in rows]
        b = c.read_spectrum(write(tmp_path, "\r\n".join(lines), "m.csv"))
        np.testing.assert_allclose(b.n, a.n)
        np.testing.assert_allclose(b.k, a.k)
        assert b.source == "m.csv"


GOOD = "0.4 1 3\n0.5 1 3\n0.6 1 3\n0.7 1 3"
NK = "tabulated nk"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        (" \n\t\n", "is empty"),
        (b"\xff\xfe\x00", "byte 0 is not UTF-8"),
        (b" " * (c.SIZE_MAX + 1), "more than 1 MiB"),
        ("DATA: [", r"is not YAML \(line 1\)"),
        ("[" * 200_000, "is not YAML"),
        ("\0", "is not YAML"),
        ("just text", "no list `DATA`"),
        ("DATA: 3", "no list `DATA`"),
        ("DATA: []", "no list `DATA`"),
        ("DATA:\n  - 1", "no list `DATA`"),
        ("DATA:\n  - type: tabulated nk", "DATA block 1 has no `data`"),
        (blocks(("formula 2", "1 2")), "DATA block 1 is of type `formula 2`"),
        (blocks(("tabulated n", GOOD.replace(" 3", ""))), "has no `k`"),
        (blocks(("tabulated k", GOOD.replace(" 3", ""))), "has no `n`"),
        (blocks((NK, GOOD), (NK, "0.8 1")), "row 1 of DATA block 2 has 2 numbers instead of 3"),
        (blocks((NK, GOOD + "\n0.8 1 x")), "row 5 of DATA block 1 holds 'x', no number"),
        (blocks((NK, GOOD + "\n0.8 1 nan")), "row 5 of DATA block 1.*not finite"),
        (blocks((NK, GOOD + "\n0.8 inf 1")), "row 5 of DATA block 1.*not finite"),
        (blocks((NK, GOOD + "\n0.8 -1 1")), "row 5 of DATA block 1.*negative"),
        (blocks((NK, GOOD + "\n0 1 1")), "row 5 of DATA block 1.*negative"),
        (blocks((NK, GOOD + "\n0.5 1 4")), "two values of `k` at 0.5 um"),
        (blocks((NK, GOOD[8:])), "0.5-0.7 um, which does not cover 0.4-0.7"),
        (blocks((NK, GOOD[:-8])), "0.4-0.6 um, which does not cover 0.4-0.7"),
        (blocks((NK, "400 1 3\n700 1 3")), "nanometres: divide by 1000"),
        (blocks((NK, GOOD.replace(" 3", " 1e300"))), "`k` runs from 1e[+]300 to 1e[+]300"),
        (blocks((NK, GOOD.replace(" 1 ", " 0 "))), "`n` runs from 0 to 0"),
    ],
)
def test_a_bad_file_is_refused_with_the_place(tmp_path, text, message):
    with pytest.raises(FileError, match=message):
        c.read_spectrum(write(tmp_path, text))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("wl,n,k\n0.4,1,2", "line 1 names the columns `wl`, `n`, `k`"),
        ("wavelength_um,n,k\n0.4,1", "line 2 has 2 numbers instead of 3"),
        ("# a\nwavelength_um;n;k\n0,4;1,0;2,0", "line 3 has 6 numbers instead of 3"),
        ("wavelength_um,n,k\n0.4,,1", "line 2 holds '', no number"),
        ("wavelength_um,n,k\n", "has no `n`"),
        ("# only words", "has no `n`"),
    ],
)
def test_a_bad_table_is_refused_with_the_line(tmp_path, text, message):
    with pytest.raises(FileError, match=message):
        c.read_spectrum(write(tmp_path, text, "metal.csv"))


def test_another_suffix_is_refused(tmp_path):
    with pytest.raises(FileError, match=r"neither \.yml nor \.csv"):
        c.read_spectrum(write(tmp_path, "x", "metal.nk"))


@pytest.mark.parametrize(
    ("reference", "source"),
    [
        (
            'P. B. Johnson and R. W. Christy.\n Title. <a href="https://doi.org/10.1/S(01)3-4">J (1972)</a>',
            "Johnson and Christy 1972, doi:10.1/S(01)3-4",
        ),
        ("1) A. D. Rakić. Title. J (1995)\n2) B. Other. Title (2001)", "Rakić 1995"),
        (
            "J. H. Weaver, C. Olson, and D. Lynch. T.\n [*J* **12**, 1 (1975)](https://doi.org/10.1103/P.12)",
            "Weaver et al. 1975, doi:10.1103/P.12",
        ),
        ("somebody, private communication", ""),
        ("", ""),
    ],
)
def test_a_reference_becomes_authors_and_year(reference, source):
    assert c._citation(reference) == source


def run(*arguments, status=0):
    result = click.testing.CliRunner().invoke(cli, ["metals", *map(str, arguments)])
    assert (result.exit_code == 0) is (status == 0), result.output
    return result


def test_the_command_lists_every_metal_and_says_what_was_clipped():
    out = run().output
    assert all(f"{name} " in out for name in METALS)
    assert "gold: red is 1.0376, outside Rec. 709" in out
    assert set(json.loads(run("--json").output)) == set(METALS)


def test_what_the_command_prints_can_be_pasted():
    lines = run("gold").output.splitlines()
    assert "  --fix fresnel=conductor --fix eta=0.010026,0.49538,1.4781 --fix k=20,2.2491,1.7788" in lines
    parameters = json.loads("{" + lines[-1] + "}")
    material = from_dict({"model": "ggx", "parameters": {"ggx": {"alpha": 0.2, **parameters}}})
    found = material.to_dict()["parameters"]["ggx"]
    assert found["fresnel"] == "conductor"
    np.testing.assert_allclose(found["eta"], METALS["gold"].eta)
    np.testing.assert_allclose(found["k"], METALS["gold"].k)


def test_the_command_derives_a_metal_from_a_file(tmp_path):
    path = write(tmp_path, blocks((NK, GOOD)))
    found = json.loads(run(path, "--json").output)["metal"]
    np.testing.assert_allclose(found["eta"], 1, rtol=1e-4)
    np.testing.assert_allclose(found["k"], 3, rtol=1e-4)
    assert max(found["worst"]) < 1e-5
    assert found["source"] == "Author et al. 1999"
    assert "--fix eta=" in run(path, "--illuminant", "A").output


def test_the_command_refuses_what_it_cannot_do(tmp_path):
    assert isinstance(run("unobtainium", status=2).exception, UserError)
    assert "is for files" in str(run("gold", "--illuminant", "E", status=2).exception)
    assert isinstance(run(tmp_path / "missing.yml", status=1).exception, FileNotFoundError)
