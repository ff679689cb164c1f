import pytest

from impactfem.verify import massless


@pytest.mark.parametrize("part", ["mass", "shift"])
def test_a_wrong_rod_is_seen(wrong, failed, monkeypatch, part):
    monkeypatch.setattr(massless, "STEPS", massless.STEPS[:2])
    monkeypatch.setattr(massless, "MESHES", (8, 16))
    if part == "shift":
        # A layer of four elements is too long for the mean over 1 ms.
        wrong(massless.Rod, "shift", lambda right, rod, n: right(rod, n) / 16.0)
    else:
        wrong(
            massless.Rod,
            "body",
            lambda right, rod, *given: (right(rod, *given)[0], 1.1 * right(rod, *given)[1]),
        )
    assert any(
        "largest mean over 1 ms" in quantity
        for quantity in failed(massless.massless_strips_head_on())
    )
