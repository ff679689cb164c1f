import hashlib
import os
import pickle
from pathlib import Path

import pytest

from impactfem.case import Case, RecordMotion, SyntheticMotion, load_case
from impactfem.dynamics.damping import Rayleigh
from impactfem.system.errors import InputError

from .faults import by_file as faults_of
from .faults import refused
from .sections import (
    BLAST,
    CABINET,
    EVERY_KEY,
    FROM_FILE,
    LOADS,
    MODES,
    OTHERS,
    PAIR,
    PIPE,
    PIPE_FILES,
    RECORDED,
    TABLE,
    TABLES,
    TRANSIENT,
    WALL,
    Base,
    with_spectrum,
)
from .texts import added

GRID = '{ minimum = "0.5 Hz", maximum = "500 Hz", per_decade = 100 }'


def test_all_faults_of_all_files_at_once(broken):
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


def test_what_needs_a_broken_part_is_not_checked(broken):
    path = broken((None, 'name = "B2"', "name = 2"), ("pair_floors.csv", "1787", "x"))
    assert set(faults_of(path)) == {
        "pair.toml: buildings[1].name",
        "pair_floors.csv: line 4, column mass [t]",
    }


def test_two_motions_of_one_direction(broken):
    path = broken((None, "[contact_laws", '[[motions]]\ndirection = "y"\n[contact_laws'))
    faults = faults_of(path)
    assert "first is motions[0]" in (faults["pair.toml: motions[1].direction"])
    assert "pair.toml: motions[1].type" in faults


@pytest.mark.parametrize(
    ("content", "kind"),
    [
        (b"", "file empty"),
        (b"\n  \n", "file empty"),
        (b"\x7fELF\x02\x01\x01\x00\x80", "file byte 0x80 at position 8"),
        (b"title = \"a\0b\"", "file NUL at position 10"),
        (b"x = " + b"[" * 20_000, "toml"),
        (b"x = " + b"1" * 5_000, "toml"),
    ],
)  # fmt: skip
def test_no_case_file_at_all(tmp_path, content, kind):
    path = tmp_path / "case.toml"
    path.write_bytes(content)
    refused(path, "case.toml: ", kind)


def test_paths_that_cannot_be_read(tmp_path):
    assert "no such file" in faults_of(tmp_path / "none.toml")["none.toml: "]
    assert "this is a directory" in faults_of(tmp_path)[f"{tmp_path.name}: "]
    pipe = tmp_path / "pipe.toml"
    os.mkfifo(pipe)
    assert "not an ordinary" in faults_of(pipe)["pipe.toml: "]
    loop = tmp_path / "loop.toml"
    loop.symlink_to(loop)
    assert faults_of(loop)["loop.toml: "]
    long = tmp_path / ("x" * 300)
    assert "name too long" in next(iter(faults_of(long).values()))


def test_permission_denied_is_a_fault(broken, monkeypatch):
    def denied(self):
        raise PermissionError(13, "Permission denied")

    path = broken()
    monkeypatch.setattr(Path, "read_bytes", denied)
    assert "read (Permission denied)" in faults_of(path)["pair.toml: "]


@pytest.mark.parametrize(
    ("line", "path"),
    [
        (r'file = "C:\Users\eng\rec.AT2"', '"C:/Users/eng/rec.AT2"'),
        (r'file = "records\RSN1.AT2"', '"records/RSN1.AT2"'),
        (r'file = "records\"', '"records/"'),
        (r'a = "x"; file = "\\server\share\rec.AT2"', '"/server/share/rec.AT2"'),
    ],
)
def test_a_backslash_in_a_path(tmp_path, line, path):
    file = tmp_path / "case.toml"
    file.write_text(f"{line}\n")
    with pytest.raises(InputError) as caught:
        load_case(file)
    assert f"write / in paths, {path}" in str(caught.value)


def test_syntax_error_names_line_and_column(broken):
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
def test_any_toml_is_refused_in_words(tmp_path, junk):
    path = tmp_path / "case.toml"
    path.write_text(junk)
    faults = faults_of(path)
    assert "case.toml: title" in faults
    assert all(faults.values())


def test_pairs_at_two_points_of_the_same_floors(broken):
    twice = """
[[contacts]]
a = { building = "B1", floor = 8, offset = ["1 m", "7.8 m", "0 m"] }
b = { building = "B2", floor = 8, offset = ["1 m", "-7.8 m", "0 m"] }
normal = [0, 1, 0]
gap = "1 cm"
law = "floor"
"""
    case = load_case(broken(more=twice))
    assert case.contacts[-1].name == "B1.floor_8-B2.floor_8#2"


def test_resolved_case(pair):
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


def test_own_damping_and_material(broken):
    own = 'name = "B2"\ndamping = { mass_coefficient = "1 1/s", stiffness_coefficient = "1 ms" }'
    case = load_case(broken((None, 'name = "B2"', own)))
    assert case.building("B2").damping.rayleigh == Rayleigh(1.0, 1e-3)
    assert case.building("B1").damping.rayleigh != Rayleigh(1.0, 1e-3)


def test_only_what_is_needed(broken):
    spans = [("[calibration]", "[[motions]]"), ("[contact_laws", "[pounding]"), ("published", "\n")]
    cut = [(None, PAIR[PAIR.index(a) : PAIR.index(b, PAIR.index(a))], "") for a, b in spans]
    case = load_case(broken(*cut))
    assert case.calibration is case.structure is case.transient is case.wall_impact is None
    assert case.contacts == case.devices == case.damping_cases == ()
    assert case.device_analysis is None
    assert case.published == {}


def test_record(written):
    path = written(RECORDED, (None, '"motion.csv"', '"motion.csv"\nscale = 2'))
    (motion,) = load_case(path).motions
    assert isinstance(motion, RecordMotion)
    assert motion.file == path.parent / "motion.csv"
    assert (motion.format, motion.scale) == ("csv", 2.0)
    motion.file.unlink()
    assert "no such file" in faults_of(path)["pair.toml: motions[0].file"]


OF_ALL_SECTIONS = pytest.mark.parametrize(
    "base",
    [
        *(RECORDED, FROM_FILE, with_spectrum(TABLE), Base(EVERY_KEY, OTHERS)),
        *(Base(TRANSIENT + CABINET + WALL, MODES), Base(PIPE, PIPE_FILES), Base(LOADS, BLAST)),
    ],
    ids=lambda base: next(iter(base.files)),
)


@OF_ALL_SECTIONS
def test_case_travels_between_processes(written, base):
    case = load_case(written(base))
    copy = pickle.loads(pickle.dumps(case))
    assert isinstance(copy, Case) and copy == case
    assert case.model_dump_json() == copy.model_dump_json()


@OF_ALL_SECTIONS
def test_hash_covers_every_file(written, base):
    path = written(base)
    case = load_case(path)
    first = case.content_hash()
    assert len(first) == hashlib.sha256().digest_size * 2
    generated = TABLES if base.structure and base is not FROM_FILE else ()
    of_all = {"pair.toml", *(f"pair_{name}.csv" for name in ("floors", "targets", "published"))}
    assert set(case.input_files) == of_all | {*base.files, *generated}
    hashes = {first}
    for name in case.input_files:
        file = path.with_name(name)
        before = file.read_bytes()
        file.write_bytes(before + b"# one more comment\n")
        hashes.add(load_case(path).content_hash())
        file.write_bytes(before)
    assert len(hashes) == len(case.input_files) + 1
    assert load_case(path).content_hash() == first


def test_hash_does_not_depend_on_the_folder(broken, pair):
    assert load_case(broken()).content_hash() == load_case(pair).digest


def test_case_is_frozen(pair):
    case = load_case(str(pair))
    with pytest.raises(ValueError, match="frozen"):
        case.title = "another"


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
def test_a_section_at_fault_hides_no_other_fault(structured, old, new, key):
    section = '[transient]\ntime_step = "1 ms"\neccentricity = "30 m"\n'
    path = structured((None, old, new), more=section)
    assert set(faults_of(path)) == {f"pair.toml: {key}", "pair.toml: transient.eccentricity"}


def test_key_structure_in_a_case_without_buildings(tmp_path):
    path = added(tmp_path / "case.toml", "[[damping_cases]]\nstructure = 1\n")
    assert {"case.toml: damping_cases[0].structure", "case.toml: buildings"} <= set(faults_of(path))
