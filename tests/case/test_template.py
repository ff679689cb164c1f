import re
from pathlib import Path

import pytest

from docs._ext.case_reference import json_schema
from impactfem.case import DeviceAnalysis, FileMesh, KelvinVoigtLaw, load_case
from impactfem.case.buildings import GeneratedMesh
from impactfem.case.calibration import Calibration, WallImpactSetup
from impactfem.case.devices import DeviceBeam
from impactfem.case.plausibility import implausible
from impactfem.case.template import PARTS, write_new_case
from impactfem.case.transient import Transient
from impactfem.device.from_case import checked_devices
from impactfem.system.errors import InputError

TARGETS = "building,mode,frequency [Hz],effective_mass [t]\nwest,1,2.2,500\neast,1,1.5,500\n"
RECORD = "time [s],acceleration [m/s2]\n0,0\n1,1\n"
PUBLISHED = "name,value,unit,source\nmotion.pga,3,m/s2,here\n"
WALLS = "wall,storeys,x1 [m],y1 [m],x2 [m],y2 [m],thickness [m]\na,1-3,0,0,20,0,0.2\n"
BAYS = "bay,wall,storey,centre [m],sill [m],width [m],height [m]\n1,a,1,5,1,2,1.5\n"
BEAMS = (
    "beam,floors,x1 [m],y1 [m],x2 [m],y2 [m],width [m],depth [m],offset [m]\n"
    "b,1-3,5,0,5,12,0.3,0.5,-0.375\n"
)
COLUMNS = "column,storeys,x [m],y [m],width_x [m],width_y [m]\nc,1-3,5,6,0.4,0.4\n"
MODES = "frequency [Hz],direction,effective_mass [kg],height [m]\n8,y,300,1\n"
FORCES = "time [s],west.floor_3-east.floor_3 [N]\n0,0\n1,1\n"
# A key for the other of two ways.
OTHER_WAY = "not both|together|Cannot overwrite|a key of type"

FLOOR = "frequency [Hz],acceleration [m/s2],direction,damping\n" + "".join(
    f"{f},5,y,{ratio}\n" for ratio in ("0.1 %", "40 %") for f in (1, 2000)
).replace(" %", "e-2")
MATRICES = {
    "mass": "1.y [kg],tip [kg],2.y [kg]\n0,0,0\n0,50,0\n0,0,0\n",
    "stiffness": "1.y [N/m],tip [N/m],2.y [N/m]\n3e6,-3e6,0\n-3e6,4e6,-1e6\n0,-1e6,1e6\n",
}


@pytest.fixture
def template(tmp_path):
    path = write_new_case(tmp_path / "new")[0]
    (tmp_path / "new_targets.csv").write_text(TARGETS)
    (tmp_path / "new_record.csv").write_text(RECORD)
    (tmp_path / "new_published.csv").write_text(PUBLISHED)
    for name, table in {"walls": WALLS, "bays": BAYS, "beams": BEAMS, "columns": COLUMNS}.items():
        (tmp_path / f"new_{name}.csv").write_text(table)
    (tmp_path / "new_forces.csv").write_text("time [ms],west.floor_3 [MN]\n0,1\n20,0\n")
    return path


def uncommented(path, begin, end):
    """Take the '# ' from the lines of a block that stands in the template as a comment."""
    lines = path.read_text(encoding="utf-8").splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith(begin))
    last = first + 1
    while lines[last].startswith("# ") and (end is None or not lines[last].startswith(end)):
        last += 1
    lines[first:last] = [line.removeprefix("# ") for line in lines[first:last]]
    path.write_text("\n".join(lines), encoding="utf-8")


def dense(path):
    """Give the material a density, which a 3D model needs; gives the text."""
    text = path.read_text(encoding="utf-8").replace("# density", "density")
    path.write_text(text, encoding="utf-8")
    return text


def test_new_case_is_accepted(tmp_path):
    paths = write_new_case(tmp_path / "my-case.v2")
    assert [path.name for path in paths] == ["my-case.v2.toml", "my-case.v2_floors.csv"]
    case = load_case(paths[0])
    assert [building.name for building in case.buildings] == ["west", "east"]
    assert len(case.contacts) == 3
    assert all("@" not in path.read_text(encoding="utf-8") for path in paths)


@pytest.mark.parametrize("minimal", [False, True])
@pytest.mark.parametrize("parts", [(), *((part,) for part in PARTS), tuple(PARTS)], ids="-".join)
def test_parts_are_good_together(tmp_path, parts, minimal):
    paths = write_new_case(tmp_path / "new", parts, minimal=minimal)
    case = load_case(paths[0])
    assert [str(one) for one in implausible(case, 10.0)] == []
    has = {
        "structure": case.structure,
        "calibration": case.calibration,
        "wall_impact": case.wall_impact,
        "transient": case.transient,
        "devices": case.devices,
        "damping_cases": case.damping_cases,
        "loads": case.loads,
        "ensemble": case.ensemble,
        "design": case.ensemble is not None and case.ensemble.structure_motions,
    }
    needed = set(parts)
    while more := {need for part in needed for need in PARTS[part]} - needed:
        needed |= more
    assert {part for part, content in has.items() if content} == needed
    texts = [path.read_text(encoding="utf-8") for path in paths]
    assert not minimal or not any(re.search(r"(?m)^#|  # |\n\n\n|\A\n", text) for text in texts)
    assert not any("@" in text for text in texts)


def test_the_shortest_case(tmp_path):
    text = write_new_case(tmp_path / "new", minimal=True)[0].read_text(encoding="utf-8")
    assert text.count("\n") < 70


def test_unknown_parts(tmp_path):
    with pytest.raises(InputError) as caught:
        write_new_case(tmp_path / "new", ["structre", "roof"])
    assert "--with = 'structre': did you mean 'structure'?" in str(caught.value)
    assert "--with = 'roof': known: structure, calibration" in str(caught.value)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("target", ["", "new.toml"])
def test_folder_or_file_name(tmp_path, target):
    names = [path.name for path in write_new_case(tmp_path / target)]
    stem = target.removesuffix(".toml") or "case"
    assert names == [f"{stem}.toml", f"{stem}_floors.csv"]


def test_every_key_is_in_the_template(template):
    text = template.read_text(encoding="utf-8")
    schema = json_schema()
    for table in (schema, *schema["$defs"].values()):
        for key in table["properties"]:
            assert re.search(rf"\b{key}\b", text), key


def test_every_optional_key_may_be_used(template):
    text = template.read_text(encoding="utf-8")
    lines = text.splitlines()
    # Of the blocks behind a '#', which are tested below, only the lines outside of them count.
    blocks = [i for i, line in enumerate(lines) if re.match(r"# \[", line)]
    inside = {j for i in blocks for j in range(i, _end_of_block(lines, i))}
    optional = [i for i, line in enumerate(lines)
                if re.match(r"# [a-z_]+ = ", line) and i not in inside]  # fmt: skip
    assert len(optional) > 12
    for index in optional:
        changed = [*lines]
        changed[index] = changed[index].removeprefix("# ")
        template.write_text("\n".join(changed), encoding="utf-8")
        try:
            load_case(template)
        except InputError as error:
            assert re.search(OTHER_WAY, str(error)), str(error)


def _end_of_block(lines, begin):
    end = begin
    while end < len(lines) and lines[end].startswith("# "):
        end += 1
    return end


def test_optional_blocks(template):
    uncommented(template, "# [calibration]", None)
    uncommented(template, '# direction = "x"', None)  # the record
    text = template.read_text(encoding="utf-8").replace('# [[motions]]\ndirection = "x"',
                                                        '[[motions]]\ndirection = "x"')  # fmt: skip
    template.write_text(text, encoding="utf-8")
    uncommented(template, "# [[contacts]]", None)
    case = load_case(template)
    # The defaults are those it shows.
    assert case.calibration.starts == Calibration.model_fields["starts"].default
    assert len(case.motions) == 2
    assert case.contacts[-1].name == "west.floor_2-east.storey_3_at_0.5"


def test_optional_structure(template):
    uncommented(template, "# [buildings.structure]", None)
    text = dense(template)
    structure = load_case(template).structure
    assert isinstance(structure.mesh, GeneratedMesh)
    assert len(structure.mesh.columns) == 1
    # The mesh of the user's own in place of that one.
    begin = text.index("[buildings.structure.mesh]")
    template.write_text(text[:begin] + text[text.index("\n# In place of that mesh") :])
    (template.parent / "new.msh").write_bytes(b"a mesh")
    uncommented(template, "# [buildings.structure.mesh]", None)
    structure = load_case(template).structure
    assert isinstance(structure.mesh, FileMesh)


def test_optional_transient(template):
    (template.parent / "new_forces.csv").write_text(FORCES)
    uncommented(template, "# [buildings.structure]", None)
    uncommented(template, "# [transient]", None)
    dense(template)
    transient = load_case(template).transient
    assert transient.forces == template.parent / "new_forces.csv"
    names = [name for probe in transient.probes for name, _ in probe.points]
    assert names == ["corner", "aisle_1", "aisle_2", "aisle_3", "aisle_4", "aisle_5"]
    assert transient.probes[2].group == "edge_3"
    # The defaults are those it shows; these keys have none.
    none = ("duration", "forces", "export_start", "export_step")
    shown = dict.fromkeys(none) | {"probes": ()}
    assert transient.model_copy(update=shown) == Transient(time_step=5e-4, maximum_frequency=200.0)


def test_optional_wall_impact(template):
    uncommented(template, "# [buildings.structure]", None)
    uncommented(template, "# [wall_impact]", None)
    text = dense(template)
    law = '[contact_laws.edge]\ntype = "kelvin-voigt"\nstiffness = "calibrated"\n'
    text = text.replace("[contact_laws.floor]", f'{law}restitution = "calibrated"\n\n'
                        "[contact_laws.floor]")  # fmt: skip
    template.write_text(text.replace('law = "floor"', 'law = "edge"'), encoding="utf-8")
    case = load_case(template)
    # The defaults are those it shows; the building has three floors.
    assert case.wall_impact == WallImpactSetup(
        building="west",
        floors=(1, 2, 3),
        displaced_floor=3,
        gap=0.01,
        displacement=-0.02,
        duration=1.3,
        time_step=0.34e-3,
        contact_spacing=0.9,
    )
    law = case.contact_laws["edge"]
    assert isinstance(law, KelvinVoigtLaw)
    assert (law.stiffness, law.restitution) == ("calibrated", "calibrated")


def test_optional_damping_cases(template):
    uncommented(template, "# [[damping_cases]]", None)
    (light,) = load_case(template).damping_cases
    assert (light.name, light.ratio, light.restitution) == ("light", 0.03, 0.7)


def test_optional_devices(template):
    (template.parent / "new_forces.csv").write_text(FORCES)
    (template.parent / "new_modes.csv").write_text(MODES)
    (template.parent / "new_floor.csv").write_text(FLOOR)
    for name, table in MATRICES.items():
        (template.parent / f"new_{name}.csv").write_text(table)
    for begin in (
        "# [buildings.structure]",
        "# [transient]",
        "# [[devices]]",
        "# [device_analysis]",
    ):
        uncommented(template, begin, None)
    text = dense(template)
    case = load_case(template)
    pump, cabinet, pipe = case.devices
    # The defaults are those it shows, but for the rigid part, which is none.
    assert pump.maximum_frequency == cabinet.maximum_frequency
    assert pump.beam == DeviceBeam(length=0.46, bending=(8e7, 8e7))
    assert pump.envelope == ("corner", "centre_3") and pump.spectra is not None
    assert [anchor.radius for anchor in pipe.anchors] == [0.3, 0.3]
    assert case.device_analysis.rigid is not None
    shown = DeviceAnalysis(duration=4.0, time_step=0.125e-3)
    assert case.device_analysis.model_copy(update={"rigid": None}) == shown
    assert checked_devices(case)[1].name == "cabinet"
    # The shape in place of the inertia.
    text = text.replace("# shape = ", "shape = ").replace("inertia = ", "# inertia = ")
    template.write_text(text, encoding="utf-8")
    assert load_case(template).devices[0].shape is not None


def test_variant_as_the_template_says(template):
    said = re.search(r"extends = \"new\.toml\"", template.read_text(encoding="utf-8"))
    variant = template.with_name("variant.toml")
    variant.write_text(f'{said[0]}\ntitle = "A variant"\n')
    assert load_case(variant).title == "A variant"


def test_nothing_is_overwritten(tmp_path):
    floors = tmp_path / "new_floors.csv"
    floors.write_text("mine")
    with pytest.raises(InputError, match=r"new_floors\.csv: this file exists already"):
        write_new_case(tmp_path / "new")
    assert floors.read_text() == "mine"
    assert not (tmp_path / "new.toml").exists()


@pytest.mark.parametrize("name", ['a"b', "a b", "-x", ".toml", ".hidden"])
def test_name_refused(tmp_path, name):
    with pytest.raises(InputError, match="expected a name of letters, digits"):
        write_new_case(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_folder_missing(tmp_path):
    with pytest.raises(InputError, match="no such folder"):
        write_new_case(tmp_path / "none" / "new")


def test_nothing_half_written(tmp_path, monkeypatch):
    opened = Path.open

    def full(self, *args, **options):
        if self.suffix == ".csv" and args == ("x",):
            raise OSError(28, "No space left on device")
        return opened(self, *args, **options)

    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(InputError, match=r"cannot be written \(No space left on device\)"):
        write_new_case(tmp_path / "new")
    assert list(tmp_path.iterdir()) == []
