"""The tables [[loads]] of a case file, and their forces."""

import numpy as np
import pytest

from impactfem.case import load_case
from impactfem.case.motions import RestMotion, read_force_table

from .faults import faults_of, refused
from .sections import BLAST, LOADS, MOTION, TRANSIENT

AT_REST = (None, MOTION, "")


def test_read(broken):
    case = load_case(broken(more=LOADS, files=BLAST))
    (loads,) = case.loads
    assert loads.direction == (0.0, -1.0, 0.0)
    faults = []
    table = read_force_table(loads.file, faults)
    assert table is not None and not faults
    assert table.floors == (("B1", 8), ("B2", 1))
    assert table.time.tolist() == pytest.approx([0.0, 5e-3, 20e-3])
    at = table.at(np.array([0.0, 2.5e-3, 20e-3, 21e-3]))
    assert at == pytest.approx(np.array([[0, 0], [1.25e6, -2e4], [0, 0], [0, 0]]))
    assert not isinstance(case.motions[0], RestMotion)
    assert load_case(broken()).loads == ()


def test_a_building_of_any_name(tmp_path):
    path = tmp_path / "blast.csv"
    for name, faults in (("model_1", 0), ("_1", 2)):
        path.write_text(f"time [s],{name}.floor_1 [N]\n0,0\n1,2\n", encoding="utf-8")
        found = []
        assert (read_force_table(path, found) is None) == bool(faults)
        assert len(found) == faults


def test_loads_alone_leave_the_ground_at_rest(broken):
    case = load_case(broken(AT_REST, more=LOADS, files=BLAST))
    (motion,) = case.motions
    assert isinstance(motion, RestMotion) and motion.direction == "y"
    assert case.shown_direction == "y"
    for new in ("title = ", "motions = []\ntitle = "):
        faults = faults_of(broken(AT_REST, (None, "title = ", new)))
        assert "[[motions]], [[loads]]" in faults["motions"]


def test_a_table_that_ends_with_a_force(tmp_path):
    path = tmp_path / "blast.csv"
    for last, found in (("0", 0), ("1e-3", 1)):
        path.write_text(f"time [s],B.floor_1 [N]\n0,5\n1,{last}\n", encoding="utf-8")
        table = read_force_table(path, [])
        assert len(list(table.early_ends(path, 2.0))) == found
        assert not list(table.early_ends(path, 1.0))


def test_a_direction_along_the_edge_of_the_3d_model(structured):
    for direction, good in (("[1, 0, 0]", False), ("[0, -2, 0]", True)):
        loads = LOADS.replace("[0, -2, 0]", direction)
        path = structured(more=TRANSIENT + loads, files=BLAST)
        if good:
            assert load_case(path).loads
        else:
            refused(path, "loads[0].direction", "of_motions B1")
