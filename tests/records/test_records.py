import numpy as np
import pytest

from impactfem.records import read_record
from impactfem.records.accelerogram import STANDARD_GRAVITY, Accelerogram, measures
from impactfem.system.errors import ImpactfemError, InputError
from impactfem.verify.motion import at2_text, cosmos_text, csmip_text, esm_text, knet_text

CSV = "time [s],acceleration [m/s2]\n0,0\n0.01,1.5\n"
A = np.array([0.5, -1.25, 3.0, 0.75] * 50)
COUNTS = [10, -20, 30, -40] * 50
TEXTS = {
    "csv": CSV,
    "at2": at2_text(A, 0.01),
    "esm": esm_text(A, 0.01),
    "cosmos": cosmos_text([("Up", "HNZ", A)], 0.01),
    "csmip": csmip_text([("Up", A)], 0.01),
    "knet": knet_text(COUNTS, 100),
}


def written(tmp_path, text, name):
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.mark.parametrize("fmt", list(TEXTS))
@pytest.mark.parametrize("name", ["record.dat", "record.csv"])
def test_the_format_may_be_named_whatever_the_ending(tmp_path, fmt, name):
    path = written(tmp_path, TEXTS[fmt], name)
    assert read_record(str(path), fmt=fmt).time_step == pytest.approx(0.01)


@pytest.mark.parametrize("fmt", list(TEXTS))
@pytest.mark.parametrize("ending", ["txt", "ASC", "V2"])
def test_an_ambiguous_ending_is_settled_by_the_content(tmp_path, fmt, ending):
    path = written(tmp_path, TEXTS[fmt], f"record.{ending}")
    assert np.array_equal(read_record(path).acceleration, read_record(path, fmt).acceleration)


@pytest.mark.parametrize(
    ("name", "fmt"),
    [("a.CSV", "csv"), ("a.AT2", "at2"), ("a.V2c", "cosmos"), ("a.EW", "knet"), ("a.NS2", "knet")],
)
def test_the_ending_tells(tmp_path, name, fmt):
    path = written(tmp_path, TEXTS[fmt], name)
    assert read_record(path).time_step == pytest.approx(0.01)
    other = "csv" if fmt != "csv" else "esm"
    with pytest.raises(InputError):
        read_record(written(tmp_path, TEXTS[other], name))


def test_no_known_format(tmp_path):
    path = written(tmp_path, CSV, "record.dat")
    known = "type format = 'csv' or 'at2' or 'esm' or 'cosmos' or 'csmip' or 'knet'"
    with pytest.raises(InputError, match=f"the ending '.dat' is not known; {known}"):
        read_record(path)
    with pytest.raises(InputError, match="format 'xls'"):
        read_record(path, "xls")
    with pytest.raises(InputError, match=r"ending '\.txt' is not known"):
        read_record(written(tmp_path, "1 2 3\n", "record.txt"))


def test_comments_before_the_header_do_not_hide_it(tmp_path):
    path = written(tmp_path, "# a\n" * 9 + CSV, "record.txt")
    assert read_record(path).acceleration[1] == 1.5


@pytest.mark.parametrize("fmt", ["at2", "csv"])
def test_samples_beyond_the_largest_number_are_a_fault(tmp_path, fmt):
    text = TEXTS[fmt].replace("m/s2", "g")
    text = (
        text.replace("1.5", "1e308") if fmt == "csv" else text.replace("3.0000000E+00", "3e308  ")
    )
    with pytest.raises(InputError, match=r"sample \d of an accelerogram|finite"):
        read_record(written(tmp_path, text, "a.csv"), fmt)


def test_paths_that_cannot_be_read(tmp_path):
    for name in ("missing.csv", "missing.v2"):
        with pytest.raises(InputError, match=f"{name}: no such file; expected"):
            read_record(tmp_path / name)
    folder = tmp_path / "folder.csv"
    folder.mkdir()
    with pytest.raises(InputError, match="directory; expected"):
        read_record(folder)


@pytest.mark.parametrize("fmt", list(TEXTS))
@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "the file is empty"),
        (b" \n\n", "the file is empty"),
        (b"\x7fELF\x00\x01", "not a text file"),
        (b"\xff\xfe\xfd", "not a"),
    ],
)
def test_empty_and_binary_files(tmp_path, fmt, content, message):
    path = tmp_path / "x.bin"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_record(path, fmt)


@pytest.mark.parametrize("fmt", list(TEXTS))
def test_a_file_cut_anywhere_is_refused(tmp_path, fmt):
    text = TEXTS[fmt] if fmt != "csv" else "time [s],a [g]\n0,0\n0.01,1\n0.02"
    lines = text.splitlines()
    # The last samples of CSV are cut unseen: it announces no number of them.
    for n in sorted({1, 3, 20, len(lines) // 2, len(lines) - 1} & set(range(1, len(lines)))):
        if fmt == "csv" and n == len(lines) - 1:
            continue
        path = written(tmp_path, "\n".join(lines[:n]), "x.any")
        with pytest.raises(InputError, match=r"x\.any"):
            read_record(path, fmt)


def test_linear_acceleration_is_integrated_exactly():
    record = Accelerogram(0.25, 3.0 + 2.0 * np.arange(9) * 0.25)
    t = record.time
    assert record.duration == 2.0
    assert record.velocity == pytest.approx(3.0 * t + t**2, abs=1e-15)
    assert record.displacement == pytest.approx(1.5 * t**2 + t**3 / 3, abs=1e-15)
    # The negative twin: the integrals belong to the piecewise-linear curve, not to a parabola.
    record = Accelerogram(0.25, t**2)
    assert record.velocity[-1] - record.duration**3 / 3 > 0.01


def test_scaling():
    record = Accelerogram(0.5, [0.0, -4.0, 2.0], "ny", "record x.csv")
    assert record.scaled(0.5).acceleration.tolist() == [0.0, -2.0, 1.0]
    assert record.scaled_to_pga(1.0).acceleration.tolist() == [0.0, -1.0, 0.5]
    assert record.scaled(0.5).origin == "record x.csv; scaled by 0.5"
    assert record.scaled(0.5).name == "ny"


def test_it_cannot_be_changed_from_outside():
    samples = np.array([0.0, 1.0])
    record = Accelerogram(0.1, samples)
    samples[0] = 9.0
    assert record.acceleration[0] == 0.0
    with pytest.raises(ValueError, match="read-only"):
        record.acceleration[0] = 1.0


@pytest.mark.parametrize(
    ("step", "samples", "message"),
    [
        (0.0, [0.0, 1.0], "time step must be positive"),
        (float("nan"), [0.0, 1.0], "time step must be positive"),
        (0.1, [1.0], "at least 2 samples"),
        (0.1, [[1.0, 2.0]], "at least 2 samples"),
        (0.1, [0.0, float("inf")], "sample 1 .* not a finite number"),
    ],
)
def test_bad_records_are_refused(step, samples, message):
    with pytest.raises(ImpactfemError, match=message):
        Accelerogram(step, samples)


def test_bad_scales_are_refused():
    record = Accelerogram(0.1, [0.0, 1.0])
    with pytest.raises(ImpactfemError, match="must not be 0"):
        record.scaled(0.0)
    with pytest.raises(ImpactfemError, match="cannot be scaled"):
        record.scaled_to_pga(-1.0)
    with pytest.raises(ImpactfemError, match="cannot be scaled"):
        Accelerogram(0.1, [0.0, 0.0]).scaled_to_pga(1.0)


def test_ten_cycles_of_a_sine():
    # Arias: π/(2g) A² T/2. Velocity A/ω (1 - cos ωt). Displacement A/ω (t - sin(ωt)/ω).
    A, f, T, h = 2.0, 1.0, 10.0, 1e-3
    t = np.arange(round(T / h) + 1) * h
    m = measures(Accelerogram(h, A * np.sin(2 * np.pi * f * t)))
    omega = 2 * np.pi * f
    assert m.pga == pytest.approx(A, rel=1e-5)
    assert m.time_of_pga == pytest.approx(0.25, abs=h)
    assert m.pgv == pytest.approx(2 * A / omega, rel=1e-5)
    assert m.pgd == pytest.approx(A / omega * T, rel=1e-5)
    assert m.arias == pytest.approx(np.pi / (2 * STANDARD_GRAVITY) * A**2 * T / 2, rel=1e-5)
    assert m.end_velocity == pytest.approx(0.0, abs=1e-9)
    assert m.end_displacement == pytest.approx(m.pgd)


def test_constant_acceleration_has_nine_tenths_of_its_duration():
    m = measures(Accelerogram(0.1, np.full(101, -3.0)))
    assert m.duration_5_95 == pytest.approx(9.0)
    assert m.arias == pytest.approx(np.pi / (2 * STANDARD_GRAVITY) * 9.0 * 10.0)
    assert m.pga == 3.0
    assert m.end_velocity == pytest.approx(-30.0)
    assert m.end_displacement == pytest.approx(-150.0)


def test_arias_of_a_ramp_is_exact_in_one_step():
    # ∫ (2t)² dt over 0..1 = 4/3; the trapezoidal rule would give 2.
    m = measures(Accelerogram(1.0, [0.0, 2.0]))
    assert m.arias == pytest.approx(np.pi / (2 * STANDARD_GRAVITY) * 4 / 3, rel=1e-14)


def test_silence_has_no_strength():
    m = measures(Accelerogram(0.1, np.zeros(5)))
    assert (m.pga, m.pgv, m.arias, m.duration_5_95) == (0.0, 0.0, 0.0, 0.0)
