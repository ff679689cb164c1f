"""The ground motion of a run."""

from impactfem.report.facts import Facts, digits, table
from impactfem.report.run_files import RunFiles

COLUMNS = (
    "direction {}; origin {}; PGA [m/s²] {}; PGV [m/s] {}; 5 to 95 % duration [s] {}; "
    "largest spectral acceleration [m/s²] {}; at [Hz] {}; damping [%] {:g}"
)


def motion_table(run: RunFiles) -> Facts | None:
    """Return the ground motions by direction; None without the stage `pounding`."""
    if not run.ran("pounding"):
        return None
    names = ("pga", "pgv", "duration_5_95", "sa_max", "sa_max_frequency")
    with run.store("motion.nc") as store:
        rows = [
            (
                one["direction"].item(),
                one["origin"].item(),
                *(digits(float(one[name]), 3) for name in names),
                100.0 * float(one["damping"]),
            )
            for one in (store.isel(motion=k) for k in range(store.sizes["motion"]))
        ]
    return table("Ground motion", COLUMNS, rows)
