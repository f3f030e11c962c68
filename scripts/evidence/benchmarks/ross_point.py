"""Resting place, coefficients and time of one loaded journal: ROSS's PlainJournal beside the quasi-static film."""

import math
import subprocess
import sys
import time
import warnings
from resource import RUSAGE_CHILDREN, RUSAGE_SELF, getrusage

warnings.filterwarnings("ignore")

from ross.bearings.lubricants import lubricants_dict  # noqa: E402
from ross.bearings.plain_journal import PlainJournal  # noqa: E402

WIDTH, DIAMETER, CLEARANCE = 0.0125, 0.025, 20e-6  # m
SPEED, VISCOSITY = 31.4159, 0.02  # rad/s, Pa.s
# Lund and Thomsen (1978), two axial grooves at right angles to the load, L/D = 0.5: their extent (degrees), the Sommerfeld number,
# eccentricity ratio, attitude angle (degrees), and coefficients.
GROOVES, SOMMERFELD = 20, 0.379
PUBLISHED = [0.570, 45.43, 3.33, 3.64, -0.43, 1.68, 6.76, 1.87, 1.87, 1.89]
NAMES = ["eccentricity ratio", "attitude, deg", "Kxx", "Kxy", "Kyx", "Kyy", "Bxx", "Bxy", "Byx", "Byy"]
# N; S = eta N D B (R/c)^2 / F with the revolutions per second N.
LOAD = VISCOSITY * SPEED / (2 * math.pi) * DIAMETER * WIDTH * (DIAMETER / 2 / CLEARANCE) ** 2 / SOMMERFELD
REPEATS, SEARCHES = 5, 200
# Cells around each half of the bush and over the whole width; and across the film, where ROSS resolves it.
CELLS = (48, 16, 10)


def ross_point() -> list[float]:
    """Eccentricity ratio, attitude angle and coefficients in the frame of this project: x along the load, y ahead of it."""
    # An oil whose viscosity does not change with temperature; ROSS fits a law through two points.
    oil = dict(lubricants_dict["ISOVG46"], liquid_viscosity1=VISCOSITY, liquid_viscosity2=VISCOSITY * (1 - 1e-9))
    around, over, across = CELLS
    bearing = PlainJournal(
        n=0, pad_axial_length=WIDTH, journal_diameter=DIAMETER, radial_clearance=CLEARANCE, n_pads=2,
        pad_arc=math.radians(180 - GROOVES), preload=0, oil_supply_temperature=323.15, speed=[SPEED], fxs_load=0,
        fys_load=-LOAD, lubricant=oil, initial_position=(0.4, -0.4), oil_flow_v=1e-2, thermal_type=None,
        total_ex_film=around, total_ez_film=over, total_ey_film=across, total_ey_pad=across)
    eccentricity, attitude = bearing.equilibrium_pos
    value = {name: float(getattr(bearing, name)[0]) * CLEARANCE / LOAD * (SPEED if name[0] == "c" else 1)
             for name in ("kxx", "kxy", "kyx", "kyy", "cxx", "cxy", "cyx", "cyy")}
    # ROSS's x is our y, its y points against the load.
    turned = [[value[k + "yy"], -value[k + "yx"], -value[k + "xy"], value[k + "xx"]] for k in "kc"]
    return [eccentricity, math.degrees(attitude), *turned[0], *turned[1]]


def ours(program: str) -> list[float]:
    numbers = (WIDTH / DIAMETER, SOMMERFELD, GROOVES, SEARCHES)
    printed = subprocess.run([program, *map(str, numbers)], check=True, capture_output=True, text=True).stdout
    return [float(number) for number in printed.split()][:-1]


def timed(run, count: int) -> tuple[list[float], float, float]:
    """What a run gives, and its CPU and wall time in seconds, one of `count` in it."""
    used = lambda: sum(sum(getrusage(who)[:2]) for who in (RUSAGE_SELF, RUSAGE_CHILDREN))  # noqa: E731
    cpu, wall = used(), time.perf_counter()
    values = run()
    return values, (used() - cpu) / count, (time.perf_counter() - wall) / count


def main() -> None:
    ross_point()  # compiles what ROSS compiles just in time
    pairs = [(timed(ross_point, 1), timed(lambda: ours(sys.argv[1]), SEARCHES)) for _ in range(REPEATS)]
    theirs, own = (runs[0][0] for runs in zip(*pairs))
    print(f"One journal at rest between two axial grooves of {GROOVES} degrees, L/D = {WIDTH / DIAMETER}, S = {SOMMERFELD}:\n")
    print("| | Lund & Thomsen (1978) | ROSS 3.1.0 | `QuasiStatic` |\n|---|---:|---:|---:|")
    for row in zip(NAMES, PUBLISHED, theirs, own):
        print("| {} | {} | {:.3f} | {:.3f} |".format(*row))
    for name, k in (("CPU", 1), ("wall", 2)):
        best = [min(run[k] for run in runs) for runs in zip(*pairs)]
        print(f"| best {name} time of {REPEATS}, ms | | {1e3 * best[0]:.0f} | {1e3 * best[1]:.2f} |")
        ratios = sorted(a[k] / b[k] for a, b in pairs)
        print(f"| ratio, {name} | | {ratios[REPEATS // 2]:.0f} ({ratios[0]:.0f} to {ratios[-1]:.0f}) | |")


if __name__ == "__main__":
    main()
