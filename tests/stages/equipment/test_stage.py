"""The stage `equipment` on the shipped frame: items on its 3D model, and on the stick beside it."""

import shutil
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from frame_case import LIGHT, QUICK, SOFT_NEIGHBOUR, floors_meet
from impactfem.case import load_case
from impactfem.device.equipment import G
from impactfem.run import loop
from impactfem.spectra.resolved import band_limited_zpa
from impactfem.stages.equipment.motion import stick_motions
from impactfem.stages.equipment.stage import EQUIPMENT
from no_pictures import no_pictures

pytestmark = pytest.mark.slow
GEOMETRY = Path(__file__).parents[3] / "geometry"
REST = (
    """
[contact_laws.floor]
type = "kelvin-voigt"
stiffness = "1e8 N/m"
restitution = 0.6
"""
    + floors_meet("0.2 mm")
    + """
[transient]
time_step = "1 ms"
maximum_frequency = "100 Hz"
"""
)
HEAD = (
    "tag,building,floor,x [m],y [m],mass [kg],mass_height [m],fy [Hz],damping [%],anchors,"
    "circle [m],bolt_area [mm2],tension [kN],shear [kN],zpa_limit [m/s2]\n"
)
ITEMS = """\
rigid,F,2,{x},{y},100,0.5,,,4,0.6,157,50,30,1
heavy,G,1,0,4,3000,0.5,8,5,,,,,,
"""


@pytest.fixture(scope="module")
def done(edited, tmp_path_factory):
    folder = tmp_path_factory.mktemp("equipment")
    for name in ("frame.toml", "frame_floors.csv", "frame.msh"):
        shutil.copy(GEOMETRY / name, folder)
    named = ("\ntitle = ", '\nequipment = "list.csv"\ntitle = ')
    path = edited(folder / "frame.toml", *QUICK, LIGHT, SOFT_NEIGHBOUR, named)
    path.write_text(path.read_text() + REST)
    # The mass centre of the floor is a probe: middle of 6 m by 4 m, with the axis of F at (0, 0).
    (folder / "list.csv").write_text(HEAD + ITEMS.format(x=0, y=0))
    with pytest.MonkeyPatch.context() as patch:
        no_pictures(patch)
        return loop.run(path, out=folder / "run", stage="equipment")


def opened(done, name):
    return xr.load_dataset(done.folder / name, engine="netcdf4")


@pytest.mark.parametrize("impact", ["with", "without"])
def test_rigid_item_has_the_motion_of_the_probe(done, impact):
    found = opened(done, "equipment.nc").sel(item="rigid", impact=impact)
    transient = opened(done, "transient.nc")
    name = "zpa" if impact == "with" else "zpa_free"
    zpa = transient[name].sel(probe="centre_2").max().item()
    assert float(found["zpa"]) == pytest.approx(zpa, rel=2e-2)
    assert float(found["moment"]) == pytest.approx(0.5 * float(found["shear_force"]))
    assert float(found["zpa_ratio"]) == pytest.approx(float(found["zpa"]))


def test_item_on_a_stick(done):
    found, sticks = opened(done, "equipment.nc"), opened(done, "pounding.nc")
    item = found.sel(item="heavy", impact="with")
    assert str(item["item_model"].values) == "stick"
    of_floor = sticks["station"].values == "G.floor_1"
    motion = sticks["acceleration"].isel(station=of_floor)[:, 0]
    step = float(sticks["time"][1])
    y = motion.sel(component="y").values
    assert float(item["zpa"]) == pytest.approx(
        band_limited_zpa(y, step, float(sticks.attrs["resolved_frequency"])), rel=2e-2
    )
    # Its oscillator amplifies the motion of the floor.
    assert float(item["shear_force"]) > 3000.0 * float(item["zpa"])
    assert np.isnan(item["ratio"])


def test_table_verdicts_and_checks(done):
    table = pd.read_csv(done.folder / "products" / "equipment.csv")
    assert list(table["tag"]) == ["rigid", "heavy"]
    assert table["verdict"].fillna("").tolist() == ["exceeded", ""]
    book = pd.read_excel(done.folder / "products" / "equipment.xlsx")
    assert list(book.columns) == list(table.columns)
    case = load_case(done.folder.parent / "frame.toml")
    verdicts = {one.id: one for one in EQUIPMENT.verdicts(case, done.folder)}
    assert set(verdicts) == {"equipment.zpa_ratio", "equipment.interaction"}
    assert verdicts["equipment.zpa_ratio"].passed is False
    (mass,) = EQUIPMENT.checks(case, done.folder)
    assert mass.passed is False


def test_floor_that_turns():
    """Of a stick that turns about z, a point at a distance moves at right angles to it."""
    time, α = np.arange(4) * 0.1, np.array([0.0, 1.0, -2.0, 0.5])
    history = np.zeros((4, 1, 3))
    history[:, 0, 0], history[:, 0, 2] = G, α
    store = xr.Dataset(
        dict.fromkeys(
            ("acceleration", "acceleration_free"), (("time", "station", "component"), history)
        )
        | {"floor_mass": ("station", [1e4]), "building_axis": (("building", "plan"), [[1.0, 2.0]])},
        coords={
            "time": time,
            "component": ["x", "y", "rz"],
            "station_building": ("station", ["B"]),
            "station_floor": ("station", [3]),
            "building": ["B"],
            "plan": ["x", "y"],
        },
        attrs={"resolved_frequency": 1e3},
    )

    class Item:
        floor, x, y = 3, 3.0, 5.0

    x, y, z = stick_motions(store, "B").samples(Item(), True)
    assert x == pytest.approx(G - 3.0 * α)
    assert y == pytest.approx(2.0 * α)
    assert not z.any()
