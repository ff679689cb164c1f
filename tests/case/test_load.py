import hashlib
import os
import pickle
from collections.abc import Callable
from pathlib import Path

import pytest

from impactfem.case import Case, RecordMotion, SyntheticMotion, load_case
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import InputError

from .faults import by_file as faults_of
from .faults import refused
from .texts import added

Broken = Callable[..., Path]


BUILDING = 'floors = "pair_floors.csv"\naxis'  # of B1 only: a comment follows that of B2
GRID = '{ minimum = "0.5 Hz", maximum = "500 Hz", per_decade = 100 }'
FLOORS_A = '{ building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 8]'
FLOORS_B = '{ building = "B2", floor = [1, 2, 3, 4, 5, 6, 7, 8]'
TWICE = """[[contacts]]
a = { building = "B1", floor = 8, offset = ["0 m", "7.8 m", "0 m"] }
b = { building = "B2", floor = 8, offset = ["0 m", "-7.8 m", "0 m"] }
normal = [0, 1, 0]
gap = "1 cm"
law = "floor"

"""

# What is replaced in the case file, by what, the key of the fault, and words of it.
BROKEN = [
    # quantities
    ('gap = "1 cm"', "gap = 0.01", "contacts[0].gap", "expected a length with its unit"),
    ('gap = "1 cm"', 'gap = "-1 cm"', "contacts[0].gap", "expected a length of at least 0"),
    ('gap = "1 cm"', "gap = 2020-01-01", "contacts[0].gap", "expected a length"),
    ('gap = "1 cm"', "", "contacts[0].gap", "missing; expected a length with its unit"),
    ('young_modulus = "33 GPa"', 'young_modulus = "0 GPa"', "materials.concrete.young_modulus",
     "expected a stress above 0"),
    ("poisson_ratio = 0.2", "poisson_ratio = 0.5", "materials.concrete.poisson_ratio",
     "expected a number of at least 0 and below 0.5"),
    ("[0.02, 1.0]", "[0.02, inf]", "calibration.stiffness_factor[1]", "expected a number above 0"),
    # keys
    ('gap = "1 cm"', 'gapp = "1 cm"', "contacts[0].gapp", "unknown key; did you mean 'gap'?"),
    ("[damping]", "[dampin]", "dampin", "unknown key; did you mean 'damping'?"),
    ("[damping]", "[dampin]", "damping", "missing; expected a table"),
    ("[[buildings]]", "[[building]]", "buildings", "missing; expected one or more tables"),
    ("starts = 40", "startz = 40", "calibration.startz", "did you mean 'starts'?"),
    ("amplification = 2.5", "zz = 2.5", "motions[0].spectrum.zz", "unknown key; known: ground_acc"),
    ("time_step = \"0.3358 ms\"", "", "pounding.time_step", "missing; expected a time"),
    # kinds of value
    ("title = ", "title = 1 #", "title", "expected a text in quotes"),
    ('title = "Two', 'title = "" # "Two', "title", "expected a text in quotes"),
    ('name = "B1"', 'name = "B 1"', "buildings[0].name", "expected a name of letters"),
    ("seed = 1\n", "seed = 1.5\n", "motions[0].seed", "expected a whole number of at least 0"),
    ("tension = true", 'tension = "yes"', "contact_laws.floor.tension", "expected true or false"),
    ("[materials.concrete]", "[materials]", "materials.young_modulus", "expected a table"),
    ("[[contacts]]", "[contacts]", "contacts", "expected one or more tables, [[contacts]], not"),
    ("[pounding]", "[[pounding]]", "pounding", "expected a table"),
    ('axis = ["23.1 m", "7.8 m"]', 'axis = ["23.1 m"]', "buildings[0].axis",
     "expected a list of 2 values, each a length with its unit"),
    ('axis = ["23.1 m", "7.8 m"]', 'axis = "23.1 m"', "buildings[0].axis", "a list of 2 values"),
    ("[0, 1, 0]", "[0, 1, 0, 0]", "contacts[0].normal", "a list of 3 values, each a number"),
    ("[0, 1, 0]", "[0, 0, 0]", "contacts[0].normal", "expected a vector that is not zero"),
    ("[0, 1, 0]", '["x", 1, 0]', "contacts[0].normal[0]", "expected a number"),
    # choices
    ('"implicit"', '"implicitly"', "pounding.update", "expected 'implicit' or 'lagged'"),
    ('direction = "y"\ntype', 'direction = "Y"\ntype', "motions[0].direction", "'x' or 'y' or 'z'"),
    ('type = "synthetic"', 'type = "synth"', "motions[0].type", "'synthetic' or 'record'"),
    ('type = "synthetic"', "", "motions[0].type", "missing; expected 'synthetic' or 'record'"),
    ('type = "kelvin-voigt"', 'type = "herz"', "contact_laws.floor.type", "'hertz' or 'hertz-d"),
    ('type = "kelvin-voigt"', "", "contact_laws.floor.type", "missing; expected 'kelvin-voigt'"),
    # references
    ('law = "floor"', 'law = "flor"', "contacts[0].law",
     "unknown contact law; did you mean 'floor'?"),
    ('[contact_laws.floor]', '[contact_laws.wall]', "contacts[0].law", "known: wall"),
    ('material = "concrete"', 'material = "concret"', "buildings[1].material",
     "unknown material; did you mean 'concrete'?"),
    ('{ building = "B1"', '{ building = "B3"', "contacts[0].a.building", "unknown building"),
    ('name = "B2"', 'name = "B1"', "buildings[1].name",
     "duplicate name, the first is buildings[0].name"),
    ('name = "B2"', 'name = "b1"', "buildings[1].name",
     "duplicate name, upper and lower case alike, the first is buildings[0].name"),
    (FLOORS_A, '{ building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 9]', "contacts[0].a.floor",
     "B1 has no floor 9; its floors are 1, 2, 3, 4, 5, 6, 7, 8"),
    (FLOORS_A, '{ building = "B1", storey = 9, relative_height = 0.5', "contacts[0].a.storey",
     "B1 has no floor 9"),
    (FLOORS_A, '{ building = "B1", floor = [1, 2]', "contacts[0].b",
     "expected lists of the same length in a and b, found 2 and 8"),
    (FLOORS_A, '{ building = "B1"', "contacts[0].a.storey", "expected either floor, or storey"),
    (FLOORS_B, '{ building = "B1", floor = [1, 2, 3, 4, 5, 6, 7, 8]', "contacts[0].b",
     "expected another building than 'B1'"),
    ("[pounding]", f"{TWICE}[pounding]", "contacts", "found B1.floor_8 and B2.floor_8 twice"),
    # files
    (BUILDING, 'floors = "none.csv"\naxis', "buildings[0].floors", "no such file"),
    (BUILDING, 'floors = "."\naxis', "buildings[0].floors", "this is a directory"),
    (BUILDING, "floors = 3\naxis", "buildings[0].floors", "expected a file name in quotes"),
    ('"pair_targets.csv"', '"none.csv"', "calibration.targets", "no such file"),
    ('"pair_published.csv"', '"none.csv"', "published", "no such file"),
    # values that contradict each other
    ('frequencies = ["1 Hz", "20 Hz"]', "", "damping.frequencies",
     "expected ratio and frequencies together"),
    ('ratio = "7 %"', 'ratio = "7 %"\nmass_coefficient = "1 1/s"', "damping.mass_coefficient",
     "not both"),
    ('damping_ratio = "12 %"', 'damping_ratio = "12 %"\nrestitution = 0.7',
     "contact_laws.floor.damping_ratio", "not both"),
    ('damping_ratio = "12 %"', "", "contact_laws.floor.damping_ratio", "missing; expected either"),
    ('"0.05 s", "0.25 s"', '"0.25 s", "0.05 s"', "motions[0].spectrum.corner_periods",
     "expected increasing corner periods"),
    ('["2 s", "5 s"]', '["5 s", "2 s"]', "motions[0].strong_phase", "the begin"),
    ('["2 s", "5 s"]', '["2 s", "50 s"]', "motions[0].strong_phase",
     "expected a phase within the duration, 16.79 s"),
    ('time_step = "5 ms"', 'time_step = "50 s"', "motions[0].time_step", "below the duration"),
    ('"0.3358 ms"', '"335.8 s"', "pounding.time_step", "below the duration, 16.79 s"),
    ("[0.02, 1.0]", "[1.0, 0.02]", "calibration.stiffness_factor", "bounds in order"),
    ('height = "30.3 m"', 'height = "40 m"', "calibration.height", "26.52 m to 35.22 m"),
    ('rigid_depth = "0.85 m"', 'rigid_depth = "2.7 m"', "calibration.rigid_depth",
     "the storey below floor 2 of B1 may become 2.62 m high"),
    ('rigid_above = "0.79 m"', 'rigid_above = "2.6 m"', "buildings[1].rigid_above",
     "the storey below floor 2 is 2.62 m high"),
    (GRID, '["2 Hz", "1 Hz"]', "spectra.frequencies", "expected increasing frequencies"),
    (GRID, '["2 Hz", 3]', "spectra.frequencies[1]", "the unit is missing; expected a frequency"),
    (GRID, "[]", "spectra.frequencies", "expected a list that is not empty"),
    (GRID, '"1 Hz"', "spectra.frequencies", "expected a table or a list, each value a frequency"),
    ('damping = ["5 %"]', "damping = []", "spectra.damping", "expected a list that is not empty"),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "key", "expected"), BROKEN)
def test_broken_case_file(broken: Broken, old: str, new: str, key: str, expected: str) -> None:
    faults = faults_of(broken((None, old, new)))
    assert expected in faults.get(f"pair.toml: {key}", ""), faults


def test_a_single_mistake_is_a_single_fault(broken: Broken) -> None:
    for old, new in [
        ('gap = "1 cm"', "gap = 0.01"),
        ('["2 s", "5 s"]', '["2 s"]'),
        ('type = "synthetic"', 'type = "synth"'),
        (GRID, '["2 Hz", 3]'),
        ('pga = "2.32 m/s2"', 'pga = "2.32 m"'),
        ("seed = 1\n", "seed = 1.5\n"),
    ]:
        assert len(faults_of(broken((None, old, new)))) == 1


def test_all_faults_of_all_files_at_once(broken: Broken) -> None:
    path = broken(
        (None, 'gap = "1 cm"', 'gap = "-1 cm"'),
        (None, 'law = "floor"', 'law = "flor"'),
        (None, "[0, 1, 0]", "[0, 0, 0]"),
        (None, "starts = 40", "startz = 40"),
        (None, 'name = "B2"', 'name = "B2"\nsecond_moment_fact = 1'),
        (None, 'pga = "2.32 m/s2"', 'pga = "2.32 m"'),
        (None, '["2 s", "5 s"]', '["2 s", "50 s"]'),
        (None, 'ratio = "7 %"', "ratio = 7"),
        ("pair_floors.csv", "1787", "-1787"),
        ("pair_targets.csv", "B2,4", "B3,4"),
        ("pair_published.csv", "121,MN", "121,MX"),
    )
    assert set(faults_of(path)) == {
        "pair.toml: contacts[0].gap",
        "pair.toml: contacts[0].law",
        "pair.toml: contacts[0].normal",
        "pair.toml: calibration.startz",
        "pair.toml: buildings[1].second_moment_fact",
        "pair.toml: motions[0].pga",
        "pair.toml: motions[0].strong_phase",
        "pair.toml: damping.ratio",
        "pair_floors.csv: line 4, column mass [t]",
        "pair_targets.csv: line 8, column building",
        "pair_published.csv: line 19, column unit",
    }


def test_what_needs_a_broken_part_is_not_checked(broken: Broken) -> None:
    path = broken((None, 'name = "B2"', "name = 2"), ("pair_floors.csv", "1787", "x"))
    assert set(faults_of(path)) == {
        "pair.toml: buildings[1].name",
        "pair_floors.csv: line 4, column mass [t]",
    }


def test_two_motions_of_one_direction(broken: Broken) -> None:
    path = broken((None, "[contact_laws", '[[motions]]\ndirection = "y"\n[contact_laws'))
    faults = faults_of(path)
    assert (
        "duplicate direction, the first is motions[0]"
        in (faults["pair.toml: motions[1].direction"])
    )
    assert "pair.toml: motions[1].type" in faults


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "the file is empty; expected a case file (TOML); 'impactfem new NAME'"),
        (b"\n  \n", "the file is empty"),
        (b"\x7fELF\x02\x01\x01\x00\x80", "not a text file (byte 0x80 at position 8 is not UTF-8)"),
        (b"title = \"a\0b\"", "not a text file (NUL at position 10)"),
        (b"x = " + b"[" * 20_000, "not valid TOML: tables nested too deeply"),
        (b"x = " + b"1" * 5_000, "not valid TOML"),
    ],
)  # fmt: skip
def test_no_case_file_at_all(tmp_path: Path, content: bytes, expected: str) -> None:
    path = tmp_path / "case.toml"
    path.write_bytes(content)
    refused(path, "case.toml: ", expected)


def test_paths_that_cannot_be_read(tmp_path: Path) -> None:
    assert "no such file" in faults_of(tmp_path / "none.toml")["none.toml: "]
    assert "this is a directory" in faults_of(tmp_path)[f"{tmp_path.name}: "]
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    assert "not an ordinary file" in faults_of(pipe)["pipe.toml: "]
    loop = tmp_path / "loop.toml"
    loop.symlink_to(loop)
    assert faults_of(loop)["loop.toml: "]
    long = tmp_path / ("x" * 300)
    assert "cannot be read (File name too long)" in next(iter(faults_of(long).values()))


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every file")
def test_file_without_permission(broken: Broken) -> None:
    path = broken()
    path.chmod(0)
    assert "cannot be read (Permission denied)" in faults_of(path)["pair.toml: "]


def test_permission_denied_is_a_fault(broken: Broken, monkeypatch: pytest.MonkeyPatch) -> None:
    def denied(self: Path) -> bytes:
        raise PermissionError(13, "Permission denied")

    path = broken()
    monkeypatch.setattr(Path, "read_bytes", denied)
    assert "cannot be read (Permission denied)" in faults_of(path)["pair.toml: "]


def test_syntax_error_names_line_and_column(broken: Broken) -> None:
    path = broken((None, "starts = 40", "starts = = 40"))
    line = path.read_text(encoding="utf-8").splitlines().index("starts = = 40") + 1
    with pytest.raises(InputError, match=f"line {line}, column 10 = 'starts = = 40': not valid"):
        load_case(path)
    path.write_text('title = "open')
    with pytest.raises(InputError, match="not valid TOML"):
        load_case(path)
    path.write_text("x = {a = 1")
    with pytest.raises(InputError, match="not valid TOML"):
        load_case(path)


@pytest.mark.parametrize(
    "junk",
    [
        "a = 1",
        "[[buildings]]",
        "buildings = 3",
        "[buildings]\nx=1",
        "buildings = [1, 2]",
        "contacts = [[]]",
        "materials = []",
        "motions = ['x']",
        "motions = {}",
        "calibration = 1",
        "contacts = [{a = 1, b = []}]",
        "spectra = {frequencies = 1}",
        "damping = {frequencies = {}}",
        "contact_laws = {a = 1}",
    ],
)
def test_any_toml_is_refused_in_words(tmp_path: Path, junk: str) -> None:
    path = tmp_path / "case.toml"
    path.write_text(junk)
    faults = faults_of(path)
    assert "case.toml: title" in faults
    assert all(faults.values())


def test_pairs_at_two_points_of_the_same_floors(broken: Broken) -> None:
    case = load_case(broken((None, "[pounding]", f"{TWICE.replace('0 m', '1 m')}[pounding]")))
    assert case.contacts[-1].name == "B1.floor_8-B2.floor_8#2"


def test_resolved_case(pair: Path) -> None:
    case = load_case(pair)
    first, second = case.buildings
    assert case.building("B2") is second
    with pytest.raises(KeyError):
        case.building("B3")
    assert first.material == case.materials["concrete"]
    assert first.damping == case.damping
    assert len(first.floors) == len(second.floors) == 8
    assert first.second_moment_factor == 1.0
    assert len(case.contacts) == 8
    assert case.contacts[7].name == "B1.floor_8-B2.floor_8"
    (motion,) = case.motions
    assert isinstance(motion, SyntheticMotion)


def test_own_damping_and_material(broken: Broken) -> None:
    own = 'name = "B2"\ndamping = { mass_coefficient = "1 1/s", stiffness_coefficient = "1 ms" }'
    case = load_case(broken((None, 'name = "B2"', own)))
    assert case.building("B2").damping.rayleigh == Rayleigh(1.0, 1e-3)
    assert case.building("B1").damping.rayleigh != Rayleigh(1.0, 1e-3)


def test_only_what_is_needed(broken: Broken) -> None:
    path = broken()
    text = path.read_text(encoding="utf-8")
    for begin, end in [("[calibration]", "[[motions]]"), ("[contact_laws", "[pounding]")]:
        text = text[: text.index(begin)] + text[text.index(end) :]
    path.write_text(text.replace('published = "pair_published.csv"', ""), encoding="utf-8")
    case = load_case(path)
    assert case.calibration is None
    assert case.contacts == ()
    assert case.published == {}


def with_record(broken: Broken, name: str = "motion.csv") -> Path:
    begin, end = "[[motions]]", "[contact_laws"
    path = broken()
    text = path.read_text(encoding="utf-8")
    record = f'[[motions]]\ndirection = "x"\ntype = "record"\nfile = "{name}"\nscale = 2\n'
    path.write_text(text[: text.index(begin)] + record + text[text.index(end) :], encoding="utf-8")
    return path


def test_record(broken: Broken) -> None:
    path = with_record(broken)
    assert "no such file" in faults_of(path)["pair.toml: motions[0].file"]
    (path.parent / "motion.csv").write_text("time [s],acceleration [m/s2]\n0,0\n1,1\n")
    (motion,) = load_case(path).motions
    assert isinstance(motion, RecordMotion)
    assert motion.file == path.parent / "motion.csv"
    assert (motion.format, motion.scale) == ("csv", 2.0)


def test_hash_covers_every_file(broken: Broken) -> None:
    path = with_record(broken)
    record = path.parent / "motion.csv"
    record.write_text("time [s],acceleration [m/s2]\n0,0\n1,1\n")
    first = load_case(path).content_hash()
    assert len(first) == hashlib.sha256().digest_size * 2
    assert load_case(path).content_hash() == first
    files = [path, record, *(path.parent / f"pair_{name}.csv"
                             for name in ("floors", "targets", "published"))]  # fmt: skip
    hashes = {first}
    for file in files:
        before = file.read_bytes()
        file.write_bytes(before + b"# one more comment\n")
        hashes.add(load_case(path).content_hash())
        file.write_bytes(before)
    assert len(hashes) == len(files) + 1
    assert load_case(path).content_hash() == first


def test_hash_does_not_depend_on_the_folder(broken: Broken, pair: Path) -> None:
    assert load_case(broken()).content_hash() == load_case(pair).digest


def test_case_is_frozen_and_travels_between_processes(pair: Path) -> None:
    case = load_case(str(pair))
    with pytest.raises(ValueError, match="frozen"):
        case.title = "another"  # type: ignore[misc]
    copy = pickle.loads(pickle.dumps(case))
    assert isinstance(copy, Case)
    assert copy == case


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('young_modulus = "33 GPa"', 'young_modulus = "33"', "materials.concrete.young_modulus"),
        ('frequencies = ["1 Hz", "20 Hz"]', "frequencies = 3", "damping.frequencies"),
        ("seed = 1\n", "seed = -1\n", "motions[0].seed"),
        ("seed = 1\n", "seed = 1\nstructure = 1\n", "motions[0].structure"),
        ('name = "B2"', 'name = "B2"\nsetback = "-1 m"', "buildings[0].setback"),
    ],
)
def test_a_section_at_fault_hides_no_other_fault(
    structured: Callable[..., Path], old: str, new: str, key: str
) -> None:
    section = '[transient]\ntime_step = "1 ms"\neccentricity = "30 m"\n'
    path = added(structured((None, old, new)), section)
    assert set(faults_of(path)) == {f"pair.toml: {key}", "pair.toml: transient.eccentricity"}


def test_key_structure_in_a_case_without_buildings(tmp_path: Path) -> None:
    path = added(tmp_path / "case.toml", "[[damping_cases]]\nstructure = 1\n")
    assert {"case.toml: damping_cases[0].structure", "case.toml: buildings"} <= set(faults_of(path))
