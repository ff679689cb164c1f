"""Keys and sections that have no effect in a case are named."""

import pytest

from impactfem.case import load_case
from impactfem.case.plausibility import implausible
from impactfem.case.template import write_new_case

DAMPING = '[[damping_cases]]\nname = "light"\nratio = "3 %"\nfrequencies = ["1 Hz", "20 Hz"]\n'
FACTORS = "stiffness_factor = 0.5\nsecond_moment_factor = 0.5"
STEP = 'time_step = "0.5 ms"\n'


@pytest.mark.parametrize(
    ("parts", "old", "new", "more", "keys"),
    [
        ((), "", "", f"{DAMPING}restitution = 0.8\n", {"damping_cases[0]"}),
        (("transient",), "", "", f"{DAMPING}restitution = 0.8\n", {"damping_cases[0]"}),
        (("wall_impact",), "", "", f"{DAMPING}restitution = 0.8\n", {"damping_cases[0]"}),
        # The impact on the wall is repeated with this damping.
        (("wall_impact",), "", "", f'{DAMPING}restitution = "calibrated"\n', set()),
        (("damping_cases",), "", "", "", set()),
        (("transient",), STEP, f'{STEP}export_start = "1 s"\n', "", {"transient.export_start"}),
        (("transient",), STEP, f'{STEP}export = true\nexport_start = "1 s"\n', "", set()),
        (("transient",), STEP, f'{STEP}patch_width = "1 m"\n', "", {"transient.patch_width"}),
        (("transient",), STEP, f'{STEP}spread = "patch"\npatch_width = "1 m"\n', "", set()),
        (("transient",), STEP, f'{STEP}solver = "full"\nband = "smaller"\n', "",
         {"transient.band", "transient.maximum_frequency"}),
        (("transient",), STEP, f'{STEP}solver = "both"\nband = "smaller"\n', "", set()),
        (("calibration",), "[calibration]", '[calibration]\nmode = "given"\nseed = 1', "",
         {"calibration.seed"}),
        ((), "[pounding]", '[pounding]\ncontact_spacing = "2 m"', "",
         {"pounding.contact_spacing"}),
        ((), "[pounding]", '[contact_search]\nlaw = "floor"\n[pounding]', "", {"contact_search"}),
        (("contact_search",), "", "", "", set()),
        (("structure",), 'name = "west"', f'name = "west"\n{FACTORS}', "",
         {"buildings[0].stiffness_factor", "buildings[0].second_moment_factor"}),
        (("structure",), 'name = "west"', f'name = "west"\nstick = "own"\n{FACTORS}', "", set()),
    ],
)  # fmt: skip
def test_keys_without_effect(tmp_path, parts, old, new, more, keys):
    path = write_new_case(tmp_path / "new", parts, minimal=True)[0]
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text((text.replace(old, new) if old else text) + more, encoding="utf-8")
    found = implausible(load_case(path), 10.0)
    assert {fault.key for fault in found if "not used" in fault.expected} == keys
    assert all("Add" in f.expected or "Change" in f.expected for f in found if f.key in keys)


@pytest.mark.parametrize("springs", [True, False])
def test_second_moments_of_storeys_by_springs(tmp_path, springs):
    path = write_new_case(tmp_path / "new", minimal=True)[0]
    if springs:
        (tmp_path / "new_floors.csv").write_text(
            "floor,mass [t],kx [kN/mm],ky [kN/mm],storey_height [m]\n1,240,90,90,3.5\n"
            "2,240,90,90,3.5\n3,240,90,90,3.5\n"
        )
    found = implausible(load_case(path), 10.0)
    keys = {fault.key for fault in found if "not used" in fault.expected}
    assert keys == ({"buildings[1].second_moment_factor"} if springs else set())


def test_pairs_of_a_variant_replace_those_of_a_search(tmp_path):
    """A variant cannot remove a section: what it replaces is no fault, and no warning."""
    write_new_case(tmp_path / "base", ("contact_search",), minimal=True)
    listed = write_new_case(tmp_path / "new", minimal=True)[0].read_text(encoding="utf-8")
    pairs = listed[listed.index("[[contacts]]") : listed.index("[pounding]")]
    path = tmp_path / "variant.toml"
    path.write_text(f'extends = "base.toml"\n\n{pairs}', encoding="utf-8")
    case = load_case(path)
    assert len(case.contacts) == 3
    assert not [one for one in implausible(case, 10.0) if one.key == "contact_search"]
