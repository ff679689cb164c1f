"""All benchmarks of the manual, run and shown."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rich.table import Table

from impactfem.system.errors import Fault, InputError
from impactfem.system.files import write_json
from impactfem.system.log import Steps
from impactfem.system.parallel import one_blas_thread, rank
from impactfem.verify import motion, spectra, sticks
from impactfem.verify.contact import laws, pairs, unilateral
from impactfem.verify.devices import device, device_spectra, device_supports
from impactfem.verify.row import Row
from impactfem.verify.shells import beams, curved, patch, plates
from impactfem.verify.waves import floor_bar, forced, frame, in_time, paper, slab

BENCHMARKS: dict[str, Callable[[], list[Row]]] = {
    "shock_on_wall": laws.shock_on_wall,
    "kelvin_voigt": laws.kelvin_voigt,
    "restitution": laws.restitution,
    "contact_energy": laws.contact_energy,
    "contact_laws": laws.contact_laws,
    "impacting_bar": laws.impacting_bar,
    "eccentric_pair": pairs.eccentric_pair,
    "storey_pair": pairs.storey_pair,
    "three_buildings": pairs.three_buildings,
    "missing_pair": pairs.missing_pair,
    "newmark_order": sticks.newmark_order,
    "energy_identity": sticks.energy_identity,
    "half_sine_pulse": sticks.half_sine_pulse,
    "record_formats": motion.record_formats,
    "eurocode_ordinates": motion.eurocode_ordinates,
    "decree_ordinates": motion.decree_ordinates,
    "oscillator_sdll06": spectra.oscillator_sdll06,
    "oscillator_exact": spectra.oscillator_exact,
    "cantilever": sticks.cantilever,
    "rg_1_122": spectra.rg_1_122,
    "spectrum_sdll06": spectra.spectrum_sdll06,
    "broadening": spectra.broadening,
    "peak_reduction": spectra.peak_reduction,
    "sdld25": spectra.sdld25,
    "paper_case": sticks.paper_case,
    "shell_rigid_body": patch.shell_rigid_body,
    "shell_patch": patch.shell_patch,
    "mindlin_plate": plates.mindlin_plate,
    "clamped_plate": plates.clamped_plate,
    "hyperbolic_paraboloid": curved.hyperbolic_paraboloid,
    "twisted_strip": curved.twisted_strip,
    "plate_forces": plates.plate_forces,
    "plate_bent_in_plane": plates.plate_bent_in_plane,
    "nafems_fv12": plates.nafems_fv12,
    "nafems_fv32": plates.nafems_fv32,
    "scordelis_lo": curved.scordelis_lo,
    "pinched_cylinder": curved.pinched_cylinder,
    "l_frame": beams.l_frame,
    "t_beam": beams.t_beam,
    "eccentric_beam": beams.eccentric_beam,
    "beam_cantilevers": beams.beam_cantilevers,
    "beam_frequencies": beams.beam_frequencies,
    "beam_rigid_body": beams.beam_rigid_body,
    "slab_pulses": slab.slab_pulses,
    "wave_speed_order": slab.wave_speed_order,
    "nafems_13t": in_time.nafems_13t,
    "newmark_order_3d": in_time.newmark_order_3d,
    "energy_identity_3d": in_time.energy_identity_3d,
    "slab_strip_impact": slab.slab_strip_impact,
    "bar_against_wall": slab.bar_against_wall,
    "modal_equation": forced.modal_equation,
    "strip_pulse": forced.strip_pulse,
    "travelling_force": forced.travelling_force,
    "superposition": frame.superposition,
    "reciprocity": frame.reciprocity,
    "error_band": frame.error_band,
    "device_table_6": device.table_6,
    "device_sdll06": device.oscillator_under_pulse,
    "device_on_shaking_anchor": device.shaking_anchor,
    "device_sdld25": device_spectra.sdld25,
    "cqc_coefficient": device_spectra.correlation_coefficients,
    "mode_combinations": device_spectra.combination_rules,
    "missing_mass": device_spectra.static_load,
    "rigid_response": device_spectra.rigid_response,
    "net_tension": device_spectra.net_tension,
    "rocking_floor": device_spectra.rocking_floor,
    "two_supports": device_spectra.two_supports,
    "sdld30": device_supports.sdld30,
    "harmonic_supports": device_supports.harmonic_supports,
    "device_under_noise": device_spectra.noise_against_spectra,
    "unilateral_bar": unilateral.unilateral_bar,
    "unilateral_damped_bar": unilateral.unilateral_damped_bar,
    "landing_block": unilateral.landing_block,
    "floor_as_a_bar": floor_bar.floor_as_a_bar,
}
FULL: dict[str, Callable[[], list[Row]]] = {
    "mindlin_plate_fine": plates.mindlin_plate_fine,
    "hyperbolic_paraboloid_fine": curved.hyperbolic_paraboloid_fine,
    "twisted_strip_fine": curved.twisted_strip_fine,
    "pinched_cylinder_fine": curved.pinched_cylinder_fine,
    "paper_floor_as_a_bar": floor_bar.paper_floor_as_a_bar,
    "paper_reduced_against_full": paper.paper_reduced_against_full,
}
"""Benchmarks that take more than a few seconds each, run only when asked for.

The last one takes about half an hour, the others some minutes."""


def verify(only: str | None = None, json_file: Path | None = None, full: bool = False) -> list[Row]:
    """Run the benchmarks.

    Args:
        only: Only those with this in their name; all when None.
        json_file: Where to write the rows as JSON.
        full: Whether the heavy ones run, too.

    Raises:
        InputError: No benchmark has `only` in its name.
        ImpactfemError: The file cannot be written.
    """
    known = {**BENCHMARKS, **FULL} if full else BENCHMARKS
    chosen = {name: run for name, run in known.items() if only is None or only in name}
    if not chosen:
        expected = f"expected a part of one of the names {', '.join(known)}"
        if not full:
            expected += f"; or with --full of {', '.join(FULL)}"
        raise InputError([Fault("command line", "--only", only, expected)])
    found: list[tuple[str, Row]] = []
    steps = Steps(dict.fromkeys(chosen, 1.0), "verify", quiet=rank() != 0)
    with one_blas_thread(), steps:
        for name, run in chosen.items():
            with steps.step(name):
                found += [(name, row) for row in run()]
    if json_file is not None:
        write_json(json_file, [{"benchmark": name, **row.as_dict()} for name, row in found])
    return [row for _, row in found]


def as_table(rows: list[Row]) -> Table:
    """The rows for a terminal."""
    table = Table("benchmark", "quantity", "reference", "computed", "unit", "error", "allowed", "")
    for row in rows:
        table.add_row(
            row.name,
            row.quantity,
            f"{row.reference:.6g}",
            f"{row.computed:.6g}",
            row.unit,
            f"{row.error:.1e}",
            f"{row.tolerance:.2g}",
            "pass" if row.passed else "FAIL",
        )
    return table
