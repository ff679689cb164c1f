"""The figure of docs/damping-study.md, from the runs of its sweep.

python docs/_ext/damping_study.py runs/npp_pair_damping_sweep/runs
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib import pyplot as plt

from impactfem.run.folder import open_run

POINTS = (("centre_8", "mass centre of floor 8"), ("edge_8", "struck edge of floor 8"))
POINTS += (("edge_7", "struck edge of floor 7"),)
LOOKS = (("black", "-"), ("#0072B2", "--"), ("#D55E00", "-."), ("#009E73", ":"))


def main(folder: Path) -> None:
    """Draw the ratios of the laws, and spectra of three points with each of them."""
    figure, axes = plt.subplots(2, 2, figsize=(9.0, 6.4), layout="constrained")
    found = []
    for path in sorted(one for one in folder.iterdir() if one.is_dir()):
        with open_run(path) as run:
            law = run.pounding["law_ratio"].isel(building=0)
            spectra = run.transient["psa"].sel(component="y").isel(damping=0)
            top = float(run.transient.attrs["maximum_frequency"])
            found.append((law.load(), spectra.sel(frequency=slice(None, top)).load()))
    found.sort(key=lambda one: -float(np.interp(85.0, one[0]["law_frequency"], one[0])))
    for (colour, dash), (law, spectra) in zip(LOOKS, found, strict=False):
        at_85 = float(np.interp(85.0, law["law_frequency"], law))
        label = f"{100.0 * at_85:.3g} % at 85 Hz"
        look = {"color": colour, "ls": dash, "lw": 1.4}
        axes[0, 0].loglog(law["law_frequency"], 100.0 * law, label=label, **look)
        for panel, (point, _) in zip(axes.flat[1:], POINTS, strict=True):
            panel.semilogx(spectra["frequency"], spectra.sel(probe=point), **look)
    axes[0, 0].set(xlim=(0.5, 150.0), ylim=(2.0, 60.0), ylabel="damping ratio of the buildings [%]")
    for panel, (_, words) in zip(axes.flat[1:], POINTS, strict=True):
        panel.set(title=words, ylabel="pseudo-acceleration along y [m/s²]", ylim=(0.0, None))
    for panel, letter in zip(axes.flat, "abcd", strict=True):
        panel.set_xlabel("frequency [Hz]")
        panel.set_title(f"({letter})", loc="left")
        panel.grid(alpha=0.3)
    axes[0, 0].legend()
    figure.savefig(Path(__file__).parents[1] / "figures" / "damping_spectra.svg")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
