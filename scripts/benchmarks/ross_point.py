"""Resting place and time of one loaded journal: ROSS's PlainJournal beside the quasi-static film."""

import math
import subprocess
import sys
import time
import warnings

warnings.filterwarnings("ignore")

from ross.bearings.lubricants import lubricants_dict  # noqa: E402
from ross.bearings.plain_journal import PlainJournal  # noqa: E402

WIDTH, DIAMETER, CLEARANCE = 0.025, 0.025, 20e-6  # m
SPEED, VISCOSITY = 31.4159, 0.02  # rad/s, Pa.s
# Raimondi and Boyd (1958), full bearing, L/D = 1: eccentricity ratio, Sommerfeld number, attitude angle (deg).
ECCENTRICITY, SOMMERFELD, ATTITUDE = 0.8, 0.0446, 36.2
# N; S = eta N D B (R/c)^2 / F with the revolutions per second N.
LOAD = VISCOSITY * SPEED / (2 * math.pi) * DIAMETER * WIDTH * (DIAMETER / 2 / CLEARANCE) ** 2 / SOMMERFELD
REPEATS = 2
# Cells around and over the whole width.
CELLS = (96, 16)


def ross_point(cells: tuple[int, int]) -> tuple[float, float, float, float]:
    """Eccentricity ratio, attitude angle (rad), largest pressure (Pa) and seconds of the search alone, without
    the dynamic coefficients that PlainJournal computes as well."""
    # An oil whose viscosity does not change with temperature; ROSS fits a power law through two points.
    oil = dict(lubricants_dict["ISOVG46"], liquid_viscosity1=VISCOSITY, liquid_viscosity2=VISCOSITY * (1 - 1e-9))
    downwards = -math.pi / 2
    bearing = PlainJournal(
        n=0,
        axial_length=WIDTH,
        journal_radius=DIAMETER / 2,
        radial_clearance=CLEARANCE,
        elements_circumferential=cells[0],
        elements_axial=cells[1],
        n_pad=1,
        pad_arc_length=360,
        preload=0,
        geometry="circular",
        reference_temperature=50,
        frequency=[SPEED],
        fxs_load=0,
        fys_load=-LOAD,
        groove_factor=[0.5],
        lubricant=oil,
        sommerfeld_type=2,
        # Near the answer; from ROSS's own default guess its search stays where it starts here.
        initial_guess=[0.7, downwards + 0.7],
        method="perturbation",
        operating_type="flooded",
        oil_supply_pressure=0,
        oil_flow_v=1e-6,
    )
    eccentricity, angle = bearing.equilibrium_pos
    (seconds,) = bearing._exec_times.values()
    return eccentricity, angle - downwards, float(bearing.Pdim_last.max()), seconds


def ours(program: str) -> tuple[float, ...]:
    numbers = (WIDTH, DIAMETER, CLEARANCE, LOAD, SPEED, VISCOSITY)
    printed = subprocess.run([program, *map(str, numbers)], check=True, capture_output=True, text=True).stdout
    return tuple(map(float, printed.split()))


def main() -> None:
    ross_point((11, 3))  # compiles what ROSS compiles just in time
    runs = [(ross_point(CELLS), ours(sys.argv[1])) for _ in range(REPEATS)]
    theirs, own = (min(column, key=lambda run: run[3]) for column in zip(*runs))
    print(f"One journal at rest, L/D = 1, {LOAD:.0f} N:\n")
    print("| film | cells | eccentricity ratio | attitude, deg | largest pressure, MPa | time |")
    print("|---|---|---|---|---|---|")
    print(f"| Raimondi & Boyd (1958) | | {ECCENTRICITY} | {ATTITUDE} | | |")
    for name, cells, (e, angle, pressure, seconds) in (
        ("ROSS PlainJournal", "%d x %d, whole width" % CELLS, theirs),
        ("`QuasiStatic`", "96 x 8, half the width", own),
    ):
        print(f"| {name} | {cells} | {e:.4f} | {math.degrees(angle):.1f} | {pressure / 1e6:.2f} | {1e3 * seconds:,.2f} ms |")
    print(f"\nratio {theirs[3] / own[3]:.0f} (best of {REPEATS} each, taken in turn)")


if __name__ == "__main__":
    main()
