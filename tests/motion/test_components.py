"""Records along different directions, by the headers of each format."""

import numpy as np
import pytest

from impactfem.case import RecordMotion
from impactfem.motion.components import same_directions
from impactfem.motion.from_case import checked_durations, ground_motions, treated_record
from impactfem.records.recording import Orientation
from impactfem.system.errors import InputError
from impactfem.verify.motion import at2_text, cosmos_text, csmip_text, esm_text, knet_text

STEP = 0.01
PULSE = np.round(100.0 * np.exp(-(((STEP * np.arange(1200) - 4.0) / 0.1) ** 2)), 4)
COUNTS = [round(1e3 * a) for a in PULSE]
STATED = "# start: 2003-01-02T03:04:10.25\n# event: X\n# station: MADE\n# sensor: surface\n"
ROWS = "".join(f"{k * STEP:.2f},{a}\n" for k, a in enumerate(PULSE))
CSMIP = csmip_text([("90 Deg", PULSE)], STEP).replace("2003 03:04:05.0 UTC\n\n\n\n",
    "2003 03:04:05.0 UTC\n(Origin: 1/2/03, 03:04:00 UTC)\n\nStation No. 111  40N\n")  # fmt: skip
TEXTS = {
    "csv": f"{STATED}time [s],EW [cm/s2]\n{ROWS}",
    "at2": at2_text(PULSE / 980.665, STEP),
    "esm": esm_text(PULSE, STEP).replace("STREAM: HNN", "STREAM: HNE"),
    "cosmos": cosmos_text([("90 deg", "HNE", PULSE)], STEP).replace("Location:", "Location: Roof"),
    "csmip": CSMIP.replace("Chan  1: 90 Deg\n", "Chan  1: 90 Deg  Location: Roof\n"),
    "knet": knet_text(COUNTS, 100, direction="5"),
}
# In each format: the other component, the vertical one, a start 2.5 s later (3 s with seconds
# alone), another station, event and sensor; what a format does not state is left out.
CHANGES = {
    "csv": {"north": ("EW [", "NS ["), "up": ("EW [", "UD ["), "later": ("04:10.25", "04:12.75"),
            "station": ("MADE", "ELSE"), "event": ("event: X", "event: Y"),
            "sensor": ("surface", "borehole"), "apart": ("03:04:10", "03:05:10")},
    "at2": {"north": ("Station, 090", "Station, 000"), "up": ("Station, 090", "Station, UP"),
            "station": ("Made Up", "Other"), "event": ("Nowhere-01", "Nowhere-02")},
    "esm": {"north": ("HNE", "HNN"), "up": ("HNE", "HNZ"), "later": ("030410.250", "030412.750"),
            "station": ("CODE: MADE", "CODE: ELSE"), "event": ("NOWHERE", "ELSEWHERE"),
            "sensor": ("STREAM: HN", "STREAM: HG"), "apart": ("_030410", "_030510")},
    "cosmos": {"north": ("90 deg", "360 deg"), "up": ("90 deg", "Up"),
               "later": ("04:10.250", "04:12.750"), "station": ("XX-MADE", "XX-ELSE"),
               "event": ("Origin: 2003", "Origin: 2004"), "sensor": ("Roof", "Basement"),
               "apart": ("03:04:10", "03:05:10")},
    "csmip": {"north": ("90 Deg", "360 Deg"), "up": ("90 Deg", "Up"),
              "later": ("03:04:05.0", "03:04:07.5"), "station": ("No. 111", "No. 112"),
              "event": ("03:04:00", "03:03:00"), "sensor": ("Roof", "Basement"),
              "apart": ("03:04:05", "03:05:05")},
    "knet": {"north": ("Dir.              5", "Dir.              4"),
             "up": ("Dir.              5", "Dir.              6"),
             "later": ("03:04:45", "03:04:48"), "station": ("MADE01", "MADE02"),
             "event": ("Origin Time       2003", "Origin Time       2002"),
             "sensor": ("Dir.              5", "Dir.              1"),
             "apart": ("03:04:45", "03:05:45")},
}  # fmt: skip
FORMATS = list(TEXTS)


@pytest.fixture
def motion(tmp_path):
    """A record of a format with changes to its header, along a direction."""

    def make(fmt, *changes, direction="x", **keys):
        text = TEXTS[fmt]
        for change in changes:
            old, new = CHANGES[fmt][change]
            assert old in text
            text = text.replace(old, new)
        path = tmp_path / f"{direction}.{fmt}"
        path.write_text(text, encoding="utf-8")
        values = {"direction": direction, "type": "record", "file": path, "format": fmt}
        return RecordMotion.model_validate(values | keys)

    return make


def peak_times(motions):
    return [
        one.accelerogram.time[np.abs(one.accelerogram.acceleration).argmax()]
        for one in ground_motions(motions)
    ]


@pytest.mark.parametrize("fmt", FORMATS)
def test_components_of_one_record(motion, fmt):
    pair = [motion(fmt), motion(fmt, "north", direction="y")]
    assert checked_durations(pair, "case.toml") == pytest.approx([11.99, 11.99])
    assert peak_times(pair) == pytest.approx([4.0, 4.0], abs=1e-3)
    records = dict(enumerate(map(treated_record, pair)))
    assert [one.recording.orientation.azimuth for one in records.values()] == [90.0, 0.0]
    assert list(same_directions(pair, records)) == []


@pytest.mark.parametrize("fmt", [fmt for fmt in FORMATS if "later" in CHANGES[fmt]])
def test_a_component_that_begins_later(motion, fmt):
    """It begins as much later in the case; where it is independent, at time 0."""
    later = 3.0 if fmt == "knet" else 2.5
    for first, second, expected in (
        ((), ("later",), [4.0, 4.0 + later]),
        (("later",), (), [4.0 + later, 4.0]),
    ):
        pair = [motion(fmt, *first), motion(fmt, "north", *second, direction="y")]
        assert peak_times(pair) == pytest.approx(expected, abs=1e-3)
        ends = [11.99 + time - 4.0 for time in expected]
        assert checked_durations(pair, "case.toml") == pytest.approx(ends)
    pair[1] = motion(fmt, "north", direction="y", independent=True)
    assert peak_times(pair) == pytest.approx([4.0, 4.0], abs=1e-3)


@pytest.mark.parametrize(
    ("fmt", "what"),
    [(f, what) for f in FORMATS for what in ("event", "station", "sensor") if what in CHANGES[f]],
)
def test_another_event_station_or_sensor(motion, fmt, what):
    """Both values are in the message; independent records may be of any."""
    first = motion(fmt)
    component = () if (fmt, what) == ("knet", "sensor") else ("north",)
    second = motion(fmt, *component, what, direction="y")
    for refused in (lambda m: checked_durations(m, "case.toml"), ground_motions):
        with pytest.raises(InputError) as caught:
            refused([first, second])
        (fault,) = caught.value.faults
        values = [getattr(treated_record(one).recording, what) for one in (first, second)]
        assert (fault.file, fault.key, fault.value) == (second.file, what, values[1])
        assert values[0] in fault.expected and values[0] != values[1]
    # Members of an ensemble are not compared with each other.
    assert len(checked_durations([first, second])) == 2
    ground_motions([first, second.model_copy(update={"independent": True})])


@pytest.mark.parametrize("fmt", [fmt for fmt in FORMATS if "apart" in CHANGES[fmt]])
def test_records_that_do_not_overlap(motion, fmt):
    with pytest.raises(InputError, match="overlap in time") as caught:
        ground_motions([motion(fmt), motion(fmt, "north", "apart", direction="y")])
    assert [fault.key for fault in caught.value.faults] == ["start"]


@pytest.mark.parametrize("fmt", FORMATS)
def test_the_same_component_twice(motion, fmt):
    pair = [motion(fmt), motion(fmt, direction="y")]
    records = dict(enumerate(map(treated_record, pair)))
    (fault,) = same_directions(pair, records)
    assert (fault.file, fault.key) == (pair[1].file, "direction")
    assert "azimuth is 90 degrees" in fault.expected
    vertical = [motion(fmt), motion(fmt, "up", direction="z")]
    records = dict(enumerate(map(treated_record, vertical)))
    assert records[1].recording.orientation == Orientation(True)
    assert list(same_directions(vertical, records)) == []


@pytest.mark.parametrize(
    ("angle", "told"), [(356, 0), (4, 0), (180, 0), (20, 1), (340, 1), (270, 1)]
)
def test_components_that_are_not_perpendicular(motion, angle, told):
    pair = [motion("cosmos"), motion("cosmos", direction="y")]
    text = pair[1].file.read_text(encoding="utf-8").replace("90 deg", f"{angle} deg")
    pair[1].file.write_text(text, encoding="utf-8")
    records = dict(enumerate(map(treated_record, pair)))

    assert len(list(same_directions(pair, records))) == told
