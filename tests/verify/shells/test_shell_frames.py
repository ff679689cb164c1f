import pytest

from impactfem.verify.shells import shell_frames


def test_softer_plates_are_seen(altered):
    altered(shell_frames, E=0.98)
    rows = shell_frames.l_frame() + shell_frames.t_beam()
    assert len(rows) == 4 and not any(row.passed for row in rows)


@pytest.mark.parametrize("factor", [0.01, 100.0])
def test_the_joint_hardly_depends_on_the_drilling_factor(factor):
    rows = shell_frames.l_frame(drilling=factor)
    assert all(row.passed for row in rows)
    assert max(row.error for row in rows) < 3e-3


def test_plates_that_do_not_meet_are_seen(monkeypatch):
    """The web ends below the flange's mid-plane and carries the force alone."""
    right = shell_frames.joined

    def apart(panels):
        (nodes, triangles), *flanges = panels
        return right([(nodes - [0.0, 0.0, 1e-3], triangles), *flanges])

    monkeypatch.setattr(shell_frames, "joined", apart)
    (row,) = shell_frames.t_beam()
    assert row.computed > 2.0 * row.reference
