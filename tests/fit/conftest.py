"""A small measured building, as a stick, as a mesh or with runs; its fits in files."""

import shutil
from pathlib import Path

import pytest

GEOMETRY = Path(__file__).parents[2] / "geometry"


def copied(folder):
    """Its files; storeys that bend as much as they shear, so that modes tell both apart."""
    for path in [*GEOMETRY.glob("updating*"), *GEOMETRY.glob("row_of_three_*.csv")]:
        shutil.copy(path, folder)
    head = "floor,mass [t],Jx [kg m2],Jy [kg m2],Jz [kg m2],Ix [m4],Iy [m4],Iz [m4],A [m2],"
    rows = [f"{k},130,6.93e5,2.12e6,2.82e6,0.8,0.8,2,4,0.02,0.02,3" for k in range(1, 5)]
    table = [f"{head}Avy [m2],Avx [m2],storey_height [m]", *rows]
    (folder / "row_of_three_b_floors.csv").write_text("\n".join(table) + "\n")
    return folder / "updating.toml"


@pytest.fixture
def case(tmp_path):
    """The measured frame of the documentation with all of its files."""
    return copied(tmp_path)


@pytest.fixture
def written(tmp_path):
    """Writes the file of a fit."""

    def write(text):
        path = tmp_path / "some_fit.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture(scope="module")
def kept_case(tmp_path_factory):
    """The same for all tests of a file."""
    return copied(tmp_path_factory.mktemp("measured"))
