from dataclasses import replace

import pytest

from impactfem.verify.shells import steel_frames


def test_frames_have_the_published_frequencies(failed):
    assert failed(steel_frames.benchmark_building()) == set()
    assert failed(steel_frames.seven_storey_frame()) == set()


@pytest.mark.parametrize("name", ["column_section", "beam_section"])
def test_a_section_that_bends_about_its_other_axis_is_seen(failed, wrong, name):
    def swapped(right, *given):
        section = right(*given)
        return replace(section, I1=section.I2, I2=section.I1)

    wrong(steel_frames, name, swapped)
    assert "frequency 1" in failed(steel_frames.benchmark_building())


def test_a_fillet_that_is_left_out_is_seen(failed, monkeypatch):
    rows = {
        name: row.model_copy(update={"r": 1e-9})
        for name, row in steel_frames.rolled_sections().items()
    }
    monkeypatch.setattr("impactfem.case.sections.rolled_sections", lambda: rows)
    assert {"A, IPE 300", "A, HEB 300"} <= failed(steel_frames.rolled_section_properties())
