"""The accelerograms of two_frames.toml, made again: two_frames_x.AT2 and two_frames_y.AT2.

    python geometry/two_frames_motion.py [FOLDER]

They are synthetic, and their headers say so; only the layout is that of records. The spectrum is
that of EN 1998-1, type 1, ground B, with 1.2 m/s² on rock; one seed for each direction.
"""

import argparse
from pathlib import Path

from impactfem.motion.design_spectrum import eurocode_spectrum
from impactfem.motion.synthesis import synthesise
from impactfem.records.accelerogram import Accelerogram

SEEDS = {"x": 11, "y": 4}
LEVEL = 1.2  # on rock [m/s2]
DURATION, TIME_STEP = 15.0, 5e-3  # [s]
STRONG_PHASE = (2.0, 8.0)  # [s]
G = 9.80665  # [m/s2]
A_LINE = 5


def main() -> None:
    """Write the two files."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parent)
    folder = parser.parse_args().folder
    target = eurocode_spectrum(1, "B", LEVEL)
    for direction, seed in SEEDS.items():
        made = synthesise(
            target,
            duration=DURATION,
            time_step=TIME_STEP,
            strong_phase=STRONG_PHASE,
            seed=seed,
            pga=target.ground_acceleration,
        )
        path = folder / f"two_frames_{direction}.AT2"
        path.write_text(at2(made.accelerogram, direction, seed), encoding="ascii")


def at2(motion: Accelerogram, direction: str, seed: int) -> str:
    """The text of a file in the layout of PEER AT2.

    Args:
        motion: The accelerogram.
        direction: "x" or "y".
        seed: What it was made with.
    """
    samples = [f"{a:15.7E}" for a in motion.acceleration / G + 0.0]
    lines = [
        "SYNTHETIC ACCELEROGRAM IN THE LAYOUT OF PEER AT2: NOT A RECORD OF AN EARTHQUAKE",
        f"EN 1998-1, type 1, ground B, a_gR = {LEVEL:g} m/s2, seed {seed}, direction {direction}",
        "ACCELERATION TIME SERIES IN UNITS OF G",
        f"NPTS= {len(samples):6d}, DT= {motion.time_step:8.4f} SEC",
        *("".join(samples[k : k + A_LINE]) for k in range(0, len(samples), A_LINE)),
    ]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
