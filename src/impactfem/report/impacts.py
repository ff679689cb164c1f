"""The impacts of a run by contact pair, and the contact laws."""

import numpy as np

from impactfem.report.facts import Facts, digits, table
from impactfem.report.run_files import RunFiles
from impactfem.stages.patches import contact_patches
from impactfem.stages.stores import names_of
from impactfem.stages.verdict import pair_words

GAPS = ["pair_rest_gap", "pair_required_separation"]


def untouched(run: RunFiles) -> bool:
    """Return whether the run computed impacts and has none."""
    return run.values.get("pounding.impacts") == 0.0


def impacts_table(run: RunFiles) -> Facts:
    """Return the impacts of each contact pair, the highest pair first."""
    with run.store("pounding.nc") as store:
        pairs = names_of(store, "pair")
        gaps = store[GAPS].to_dataframe()
        every = store[[name for name in store if store[name].dims == ("impact",)]].to_dataframe()
    rows, apart = [], []
    for name in reversed(pairs):
        hits = every[every["impact_pair"] == name]
        words = pair_words(name)
        if hits.empty:
            apart.append(words)
            continue
        main = hits.iloc[hits["impact_peak_force"].to_numpy().argmax()]
        rows.append(
            (
                words,
                len(hits),
                digits(1e-6 * main["impact_band_force"], 4),
                digits(1e-6 * main["impact_peak_force"], 4),
                main["impact_peak_time"],
                1e3 * main["impact_duration"],
                digits(main["impact_approach"], 3),
                1e3 * main["impact_penetration"],
                *(1e3 * gaps.loc[name, column] for column in GAPS),
            )
        )
    columns = (
        "contact pair {}; impacts {}; force up to 100 Hz [MN] {}; peak [MN] {}; at [s] {:.3f}; "
        "duration [ms] {:.1f}; approach velocity [m/s] {}; penetration [mm] {:.2f}; "
        "gap [mm] {:.0f}; required gap [mm] {:.0f}"
    )
    note = f"Without impact: {', '.join(apart)}." if apart else ""
    if not pairs:
        note = "The case defines no contact pairs."
    note = " ".join([note, *(f"{patch}." for patch in contact_patches(run.case))]).strip()
    return table("Impacts of each contact pair", columns, rows, note)


def laws_table(run: RunFiles) -> Facts | None:
    """Return the contact laws with their parameters; None without contact pairs."""
    with run.store("pounding.nc") as store:
        names = ("pair_law", "pair_stiffness", "pair_stiffness_unit", "pair_restitution")
        laws = [tuple(store[name].values[k] for name in names) for k in range(store.sizes["pair"])]
    rows = [
        (law, laws.count((law, K, unit, ratio)), f"{digits(K, 3)} {unit}".strip(), ratio)
        for law, K, unit, ratio in dict.fromkeys(laws)
        if np.isfinite(K)
    ]
    columns = "contact law {}; pairs {}; stiffness {}; restitution {:.3g}"
    return table("Contact laws", columns, rows)
