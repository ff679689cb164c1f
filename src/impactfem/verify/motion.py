"""Records in the agencies' layouts read back, and ordinates of the standards' spectra."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from impactfem.motion import (
    STANDARD_GRAVITY,
    Accelerogram,
    decree_spectrum,
    eurocode_spectrum,
    read_record,
    write_csv,
)
from impactfem.system.log import quiet
from impactfem.verify.record_files import at2_text, cosmos_text, csmip_text, esm_text, knet_text
from impactfem.verify.row import Row, Rows


def record_formats() -> list[Row]:
    """Each format round trip: a file in the agency's layout with samples known, read back."""
    step = 0.005
    gal = np.round(100.0 * np.random.default_rng(11).standard_normal(400), 5)
    counts = [int(c) for c in np.round(1e4 * np.random.default_rng(5).standard_normal(400)) - 10704]
    known = np.array(counts) * (3920.0 / 6182761.0)
    g = np.round(gal / 980.0, 6)
    channels = [("90 deg", "HNE", -gal), ("360 deg", "HNN", gal)]
    csmip = csmip_text([(orientation, samples) for orientation, _, samples in channels], step)
    rows = Rows("", "the samples the file was written with")
    with TemporaryDirectory() as folder, quiet():
        for name, file, text, component, expected in (
            ("AT2", "a.AT2", at2_text(g, step), None, g * STANDARD_GRAVITY),
            ("ESM", "a.ASC", esm_text(gal, step), None, 0.01 * gal),
            ("COSMOS", "a.V2c", cosmos_text(channels, step), "HNN", 0.01 * gal),
            ("CSMIP", "a.V2", csmip, "2", 0.01 * gal),
            ("K-NET", "a.NS", knet_text(counts, 200), None, 0.01 * (known - known.mean())),
            ("CSV", "a.csv", None, None, 0.01 * gal),
        ):
            path = Path(folder) / file
            if text is None:
                write_csv(Accelerogram(step, 0.01 * gal), path)
            else:
                path.write_text(text, encoding="utf-8")
            record = read_record(path, component=component)
            error = np.abs(record.acceleration - expected).max()
            rows.name = f"{name} round trip"
            rows.add("largest error of a sample", 0.0, error, "m/s2", 1e-12)
            rows.add("time step", step, record.time_step, "s", 1e-12)
    return rows


def eurocode_ordinates() -> list[Row]:
    """EN 1998-1: ordinates at 0, T_B, T_C, T_D and 2 T_D from the standard's tables by hand.

    With a_gR = 1 m/s2 and γ_I = 1: S, 2.5 S, 2.5 S, 2.5 S T_C/T_D, a quarter of that.
    """
    # Type, ground, S, T_C/T_D from tables 3.2 and 3.3; corner periods [s].
    hand = [
        (1, "A", 1.0, (0.15, 0.4, 2.0), 0.2), (1, "B", 1.2, (0.15, 0.5, 2.0), 0.25),
        (1, "C", 1.15, (0.2, 0.6, 2.0), 0.3), (1, "D", 1.35, (0.2, 0.8, 2.0), 0.4),
        (1, "E", 1.4, (0.15, 0.5, 2.0), 0.25), (2, "A", 1.0, (0.05, 0.25, 1.2), 25 / 120),
        (2, "B", 1.35, (0.05, 0.25, 1.2), 25 / 120), (2, "C", 1.5, (0.1, 0.25, 1.2), 25 / 120),
        (2, "D", 1.8, (0.1, 0.3, 1.2), 0.25), (2, "E", 1.6, (0.05, 0.25, 1.2), 25 / 120),
    ]  # fmt: skip
    rows = Rows("EN 1998-1", "EN 1998-1:2004, 3.2.2.2, tables 3.2 and 3.3")
    for kind, ground, S, periods, falls in hand:
        spectrum = eurocode_spectrum(kind, ground, 1.0)
        T_B, T_C, T_D = periods
        frequency = np.array([np.inf, 1.0 / T_B, 1.0 / T_C, 1.0 / T_D, 0.5 / T_D])
        ordinates = spectrum.pseudo_acceleration(frequency)
        expected = S * np.array([1.0, 2.5, 2.5, 2.5 * falls, 0.625 * falls])
        error = np.abs(ordinates / expected - 1.0).max()
        quantity = f"type {kind}, ground {ground}: largest error at 0, T_B, T_C, T_D, 2 T_D"
        rows.add(quantity, 0.0, error, "-", 1e-12)
    damped = eurocode_spectrum(1, "B", 2.0, importance_factor=1.4, damping=0.1)
    plateau = damped.pseudo_acceleration(1.0 / 0.3)
    quantity = "plateau, type 1 B, a_gR 2 m/s2, γ_I 1.4, 10 %: 2 x 1.4 x 1.2 x 2.5 √(10/15)"
    rows.add(quantity, 6.858571279, plateau, "m/s2", 1e-9)
    source = "EN 1998-1:2004, 3.2.2.3, table 3.4"
    for kind, level in ((1, 0.9), (2, 0.45)):
        found = eurocode_spectrum(kind, "C", 1.0, vertical=True).pseudo_acceleration(10.0)
        quantity = f"vertical plateau, type {kind}: 3 x {level:g}"
        rows.add(quantity, 3.0 * level, found, "m/s2", 1e-12, source)
    return rows


def decree_ordinates() -> list[Row]:
    """The French decrees: plateaus and ordinates at 1 s by hand."""
    ordinary = "arrêté of 22 October 2010, article 4"
    special = "arrêté of 4 October 2010, article 12-3"
    # Zone, ground, γ_I, text, vertical, period [s], ordinate by hand [m/s2], how, source.
    hand = [
        (1, "A", 1.0, "ordinary", False, 0.1, 1.0, "0.4 x 2.5", ordinary),
        (2, "E", 1.0, "ordinary", False, 1.0, 1.4175, "0.7 x 1.8 x 2.5 x 0.45", ordinary),
        (3, "D", 1.0, "ordinary", False, 0.3, 4.4, "1.1 x 1.6 x 2.5", ordinary),
        (4, "B", 1.2, "ordinary", False, 0.2, 6.48, "1.6 x 1.2 x 1.35 x 2.5", ordinary),
        (4, "C", 1.4, "ordinary", False, 1.0, 3.36, "1.6 x 1.4 x 1.5 x 2.5 x 0.4", ordinary),
        (5, "B", 1.0, "ordinary", False, 1.0, 4.5, "3.0 x 1.2 x 2.5 x 0.5", ordinary),
        (4, "B", 1.2, "special", False, 0.2, 5.76, "1.6 x 1.2 x 1.2 x 2.5", special),
        (4, "A", 1.0, "ordinary", True, 0.1, 3.84, "1.6 x 0.8 x 3", ordinary),
        (5, "A", 1.0, "ordinary", True, 0.2, 8.1, "3.0 x 0.9 x 3", ordinary),
    ]
    rows = Rows("French decrees")
    for zone, ground, factor, text, vertical, period, ordinate, how, source in hand:
        spectrum = decree_spectrum(
            zone, ground, importance_factor=factor, text=text, vertical=vertical
        )
        way = "vertical" if vertical else f"ground {ground}"
        quantity = f"zone {zone}, {way}, {text}, at {period:g} s: {how}"
        found = spectrum.pseudo_acceleration(1.0 / period)
        rows.add(quantity, ordinate, found, "m/s2", 1e-12, source)
    return rows


BENCHMARKS = (record_formats, eurocode_ordinates, decree_ordinates)
