"""The choice of the synthetic motion of npp_pair.toml, made again (docs/motion-of-the-paper.md).

    python geometry/npp_motion.py [--corner 0.25] [--iterations 1] [--seeds 400]

Prints the spread over the seeds and the five seeds that come closest to the published motion.
"""

import argparse
from pathlib import Path

import numpy as np

from impactfem.case import SyntheticMotion, load_case
from impactfem.coupling.from_case import calibration_of, system_of
from impactfem.coupling.impacts import impacts
from impactfem.coupling.pounding import interpolate_ground, simulate
from impactfem.motion.from_case import ground_motions

# Section 2, figure 8, and the approach speed that follows from 121 MN with K = 1e11 N/m, xi = 0.12.
PUBLISHED = {
    "Sa max [m/s2]": 7.17,
    "at [Hz]": 5.12,
    "u B1 [cm]": 2.0,
    "u B2 [cm]": 3.0,
    "approach [m/s]": 0.36,
}
STRONG_PHASE = (2.0, 5.0)


def main() -> None:
    """Print the spread over the seeds and the closest ones."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--corner", type=float, default=0.25, help="corner period T_C [s]")
    parser.add_argument("--level", type=float, default=2.32, help="a_g S [m/s2]")
    parser.add_argument("--iterations", type=int, default=1)
    parser.add_argument("--seeds", type=int, default=400)
    options = parser.parse_args()
    case = load_case(Path(__file__).with_name("npp_pair.toml"))
    (motion,) = case.motions
    if not isinstance(motion, SyntheticMotion):
        raise SystemExit("npp_pair.toml has no synthetic motion")
    low, _, high = motion.spectrum.corner_periods
    spectrum = motion.spectrum.model_copy(
        update={
            "ground_acceleration": options.level,
            "corner_periods": (low, options.corner, high),
        }
    )
    system = system_of(case, calibration_of(case))
    dt = case.pounding.time_step
    tops = [system.floor_dofs(stick.name)[-1, 1] for stick in system.sticks]
    found = []
    for seed in range(options.seeds):
        update = {"seed": seed, "iterations": options.iterations, "spectrum": spectrum}
        (made,) = ground_motions([motion.model_copy(update=update)])
        record = made.accelerogram
        ground = interpolate_ground(
            [(1, record.time_step, record.acceleration)], dt, round(motion.duration / dt) + 1
        )
        response = simulate(system, ground, dt)
        main_impact = max(impacts(response), key=lambda i: i.peak_force, default=None)
        if main_impact is None:
            continue
        psa = made.spectrum.psa[0, 0]
        values = {
            "Sa max [m/s2]": psa.max(),
            "at [Hz]": made.spectrum.frequency[psa.argmax()],
            "u B1 [cm]": 100.0 * np.abs(response.u[:, tops[0]]).max(),
            "u B2 [cm]": 100.0 * np.abs(response.u[:, tops[1]]).max(),
            "approach [m/s]": main_impact.approach,
        }
        distance = np.sqrt(np.mean([np.log(values[k] / PUBLISHED[k]) ** 2 for k in PUBLISHED]))
        found.append((distance, seed, made.measures.time_of_pga, main_impact.peak_force, values))
    print("percentiles over the seeds: 5, 16, 50, 84, 95")
    for name in PUBLISHED:
        spread = np.percentile([values[name] for *_, values in found], [5, 16, 50, 84, 95])
        print(f"  {name:15s}", "  ".join(f"{x:7.3f}" for x in spread), f"  paper {PUBLISHED[name]}")
    forces = np.percentile([force for *_, force, _ in found], [5, 16, 50, 84, 95]) / 1e6
    print(f"  {'force [MN]':15s}", "  ".join(f"{x:7.1f}" for x in forces), "  paper 121, not used")
    print("closest, with the peak ground acceleration inside the strong phase:")
    inside = [row for row in found if STRONG_PHASE[0] <= row[2] <= STRONG_PHASE[1]]
    for distance, seed, time, force, values in sorted(inside, key=lambda row: row[0])[:5]:
        texts = "  ".join(f"{name} {value:.3f}" for name, value in values.items())
        print(
            f"  seed {seed}: distance {distance:.3f}; PGA at {time:.2f} s; {texts};"
            f" force {force / 1e6:.0f} MN"
        )


if __name__ == "__main__":
    main()
