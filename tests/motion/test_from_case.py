import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.errors import InputError
from impactfem.motion import read_record
from impactfem.motion.from_case import check_records, ground_motions


@pytest.fixture
def record(with_record, sine, tmp_path):
    """The motion of a case with the sine record and options; scalars of it are known."""

    def make(options="", content=sine):
        case = load_case(with_record(tmp_path, content, options))
        return ground_motions(case.motions)

    return make


def test_a_synthetic_motion(new_case, tmp_path):
    (motion,) = ground_motions(load_case(new_case(tmp_path)).motions)
    assert motion.direction == "y" and motion.misfit is not None
    a = motion.accelerogram
    assert np.abs(a.acceleration).max() == pytest.approx(3.0) == motion.measures.pga
    assert a.duration == pytest.approx(3.0) and a.time_step == pytest.approx(5e-3)
    assert abs(motion.measures.end_velocity) < 1e-12
    # 2.5 times 3 m/s2 on the plateau, 3 m/s2 at the stiff end.
    assert motion.target.shape == motion.spectrum.frequency.shape
    assert motion.target.max() == pytest.approx(7.5)
    plateau = (motion.spectrum.frequency > 2.5) & (motion.spectrum.frequency < 6.0)
    assert motion.target[plateau] == pytest.approx(7.5)
    assert motion.spectrum.psa[0, 0, plateau].mean() == pytest.approx(7.5, rel=0.1)
    assert "seed 1" in a.origin


def test_another_seed_is_another_motion(new_case, tmp_path):
    folders = [tmp_path / name for name in "ab"]
    for folder in folders:
        folder.mkdir()
    changes = [(), (("seed = 1 ", "seed = 2 "),)]
    one, other = (
        ground_motions(load_case(new_case(folder, *change)).motions)[0].accelerogram.acceleration
        for folder, change in zip(folders, changes, strict=True)
    )
    again = ground_motions(load_case(folders[0] / "small.toml").motions)[0].accelerogram
    assert np.array_equal(one, again.acceleration)
    assert np.abs(one - other).max() > 1.0


def test_a_record(record, tmp_path):
    (motion,) = record()
    assert motion.target is None and motion.misfit is None and motion.direction == "y"
    file = read_record(tmp_path / "record.csv")
    assert np.array_equal(motion.accelerogram.acceleration, file.acceleration)
    assert motion.measures.pga == pytest.approx(3.0, rel=1e-3)
    # Resonance of a steady state is 10 times at 5 %; three cycles reach 6 times of it.
    assert motion.spectrum.damping == pytest.approx([0.05])
    largest = np.argmax(motion.spectrum.psa[0, 0])
    assert motion.spectrum.frequency[largest] == pytest.approx(1.5, rel=0.05)
    reached = 3.0 * 10.0 * (1.0 - np.exp(-0.05 * 3.0 * np.pi * 2.0))
    assert motion.spectrum.psa[0, 0, largest] == pytest.approx(reached, rel=0.05)


@pytest.mark.parametrize(
    ("options", "pga"),
    [("scale = 0.5", 1.5), ("scale = 1.0", 3.0), ('pga = "4.5 m/s2"', 4.5)],
)
def test_a_scaled_record(record, options, pga):
    (motion,) = record(options)
    assert motion.measures.pga == pytest.approx(pga, rel=1e-3)
    assert np.abs(motion.accelerogram.acceleration).max() == motion.measures.pga


def test_a_pga_keeps_the_signs(record):
    (motion,) = record('pga = "1 m/s2"', "time [s],acceleration [m/s2]\n0,0\n0.1,-5\n0.2,2\n")
    assert motion.accelerogram.acceleration == pytest.approx([0.0, -1.0, 0.4])


def test_the_order_of_the_case(record):
    text = 'scale = 0.5\n[[motions]]\ndirection = "x"\ntype = "record"\nfile = "record.csv"'
    assert [motion.direction for motion in record(text)] == ["y", "x"]


def test_a_record_of_zeros_cannot_be_scaled(record):
    with pytest.raises(InputError, match=r"record\.csv"):
        record('pga = "3 m/s2"', "time [s],acceleration [m/s2]\n0,0\n0.1,0\n0.2,0\n")


def test_records_are_checked(with_record, sine, new_case, tmp_path):
    good = load_case(with_record(tmp_path, sine)).motions
    check_records(good)
    (tmp_path / "synthetic").mkdir()
    check_records(load_case(new_case(tmp_path / "synthetic")).motions)
    (tmp_path / "record.csv").write_text("time [s],acceleration [m/s2]\n0,0\n0,1\n")
    with pytest.raises(InputError, match=r"record\.csv: line 3.*ascend") as error:
        check_records((*good, *good))
    assert len(error.value.faults) == 2
