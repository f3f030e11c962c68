"""What the paper's tables say when computed with. No simulation."""

import csv
import math
from pathlib import Path
from statistics import NormalDist, mean, stdev

ROOT = Path(__file__).resolve().parents[3]
PAPER = ROOT / "studies" / "paper"
# The columns of Table 3 that stand in Table 1.
COLUMNS = {"h": "h_mm", "C": "C_Npm", "beta": "beta_Nspm", "F0": "F0_N", "epsilon": "eps_mm", "B": "B_mm", "D": "D_mm"}
# The load law of the stand (its start values): lever ratio, travel ratio, offset (m), phase (rad).
LEVER, TRAVEL, OFFSET, PHASE = 16.621, 15.74, 0.03267, math.radians(88.9)
RADIUS = 0.0125
# How far the farthest of 50 normal numbers is expected to be from the mean, in deviations.
OF_50 = 2.249
# The ten points that section 5.5 names.
NAMED = [3, 11, 24, 25, 37, 40, 42, 46, 48, 49]


def rows(path):
    with open(path, newline="", encoding="utf-8") as table:
        return list(csv.DictReader(table))


def by_symbol(name):
    return {row["symbol"]: {k: number(v) for k, v in row.items()} for row in rows(PAPER / name)}


def number(text):
    try:
        return float(text)
    except ValueError:
        return text


def load(row, omega):
    """F_N at the end of a run, N: the load law at a row's parameters (SI)."""
    swing = row["C"] * math.sin(PHASE) + row["beta"] * omega * math.cos(PHASE)
    return LEVER * (row["F0"] - row["C"] * OFFSET + TRAVEL * row["epsilon"] * swing)


def amplitude(c, beta, epsilon, omega):
    """Half the swing of F_N over a turn, N."""
    return LEVER * TRAVEL * epsilon * math.hypot(c, beta * omega)


def slope(x, y):
    mx, my = mean(x), mean(y)
    return sum((a - mx) * (b - my) for a, b in zip(x, y)) / sum((a - mx) ** 2 for a in x)


def table_1(one, three):
    """Per parameter: mean and deviation of Table 3's rows, how many standard errors they are from Table 1's mean, how many lie
    outside of its accuracy, and what 50 draws of Table 1 span."""
    found, within = {}, [True] * len(three)
    for symbol, column in COLUMNS.items():
        values = [row[column] for row in three]
        t = one[symbol]
        found[f"{symbol}_mean"], found[f"{symbol}_sd"] = mean(values), stdev(values)
        found[f"{symbol}_off"] = (mean(values) - t["average"]) / (t["deviation"] / math.sqrt(len(values)))
        inside = [abs(value - t["nominal"]) < t["accuracy"] + 1e-9 for value in values]
        found[f"{symbol}_outside"], within = inside.count(False), [a and b for a, b in zip(within, inside)]
        found[f"{symbol}_from"], found[f"{symbol}_to"] = (t["average"] + side * OF_50 * t["deviation"] for side in (-1, 1))
    found["within_all"] = within.count(True)
    h = one["h"]
    found["h_within"] = 100 * (2 * NormalDist().cdf(h["accuracy"] / h["deviation"]) - 1)
    return found


def table_2(two, omega):
    torque, force, power = (two[name]["nominal"] for name in ("M", "F_N", "P_fr"))
    quadrature = math.hypot(two["M"]["accuracy"], two["n"]["accuracy"]) / 100
    oil, bearing = two["T_oil"], two["T_bearing"]
    return {
        "omega": omega,
        "power": torque * omega,
        "power_limit": torque * omega * (two["M"]["accuracy"] + two["n"]["accuracy"]) / 100,
        "power_quadrature": torque * omega * quadrature,
        "mu": torque / (force * RADIUS),
        "pressure": force / (0.019 * 0.025) / 1e6,
        "oil_share": 100 * oil["accuracy"] / oil["nominal"],
        "power_share": 100 * two["P_fr"]["accuracy"] / power,
        "bearing_kelvin": bearing["nominal"] * bearing["accuracy"] / 100,
        "bearing_low": bearing["nominal"] * (1 - bearing["accuracy"] / 100),
    }


def table_3(one, two, three, omega):
    """The load law, friction and temperatures in the rows; which of them Table 2 accepts."""
    errors = [load({"F0": r["F0_N"], "C": r["C_Npm"], "beta": r["beta_Nspm"], "epsilon": r["eps_mm"] / 1e3}, omega) - r["F_N_N"]
              for r in three]
    powers = [r["P_fr_W"] for r in three]
    latent = {int(r["point"]): float(r["h_mm"]) for r in rows(ROOT / "studies" / "calibration-table3.csv")}
    viscosities = [r["P_fr_W"] * latent[int(r["point"])] / 1e3
                   / (2 * math.pi * omega**2 * (r["D_mm"] / 2e3) ** 3 * (r["B_mm"] / 1e3)) for r in three]
    low = {name: two[name]["nominal"] - tolerance for name, tolerance in (("F_N", 52.5), ("P_fr", 3), ("T_oil", 0.5))}
    high = {name: 2 * two[name]["nominal"] - low[name] for name in low}

    def passes(row, kelvin):
        values = {"F_N": row["F_N_N"], "P_fr": row["P_fr_W"], "T_oil": row["T_oil_degC"]}
        return all(low[n] <= v <= high[n] for n, v in values.items()) and abs(row["T_bearing_degC"] - 82) <= kelvin

    printed = [int(r["point"]) for r in three if passes(r, 0.615)]
    absolute = [int(r["point"]) for r in three if passes(r, 0.75)]
    ten = [r for r in three if int(r["point"]) in NAMED]
    fill = {name: 100 * (max(r[column] for r in ten) - min(r[column] for r in ten)) / (high[name] - low[name])
            for name, column in (("F_N", "F_N_N"), ("P_fr", "P_fr_W"))}
    # Clearances are printed to 0.01 mm, in row 50 to 0.001 mm.
    off = {int(r["point"]): abs(latent[int(r["point"])] - r["h_mm"]) for r in three}
    ends = [point for point in off if off[point] > (0.0005 if point == 50 else 0.005) - 1e-6]
    torque = two["M"]
    by_torque = sum(int(r["point"]) in NAMED and abs(r["P_fr_W"] / omega / torque["nominal"] - 1) <= torque["accuracy"] / 100
                    for r in three)
    mean_row = {symbol: one[symbol]["average"] for symbol in ("F0", "C", "beta")}
    nominal = load(mean_row | {"epsilon": 0.7e-3}, omega)
    # F0 and C vary; the rest moves F_N by less than 1 N.
    d_c = (load(mean_row | {"C": 110, "epsilon": 0.7e-3}, omega) - nominal)
    spread = math.hypot(LEVER * 6, d_c)
    normal = NormalDist(nominal, spread)
    return {
        "law_worst": max(map(abs, errors)),
        "law_share": 100 * max(abs(e) / r["F_N_N"] for e, r in zip(errors, three)),
        "rows": len(three),
        "passed": len(printed), "passed_absolute": len(absolute),
        "missing": ", ".join(map(str, sorted(set(NAMED) - set(printed)))),
        "same": "the ten named" if absolute == NAMED else "others than the named",
        "bearing_slope": slope(powers, [r["T_bearing_degC"] for r in three]),
        "oil_slope": slope(powers, [r["T_oil_degC"] for r in three]),
        "steady_slope": (two["T_bearing"]["nominal"] - two["T_oil"]["nominal"]) / two["P_fr"]["nominal"],
        "thick_low": min(viscosities), "thick_high": max(viscosities),
        "by_torque": by_torque,
        "fill_load": fill["F_N"], "fill_power": fill["P_fr"], "ends": ", ".join(map(str, ends)),
        # That ten points drawn at random lie among the 37 of 50 with the right temperatures.
        "all_ten": 100 * math.comb(37, 10) / math.comb(50, 10),
        "load_nominal": nominal,
        "load_share": 100 * (normal.cdf(high["F_N"]) - normal.cdf(low["F_N"])),
    }


def aligned(name, values):
    """A line of the block of Table 3: a value for each of its points."""
    return f"{name:14}" + "".join(f"{value:>8}" for value in values)


def table_3_lines():
    """The points, and the clearances that the stand needs for them."""
    latent = rows(ROOT / "studies" / "calibration-table3.csv")
    return [aligned("point", (r["point"] for r in latent)), aligned("h in A, mm", (f"{float(r['h_mm']):.4f}" for r in latent))]


def swing(two, omega):
    """The load's swing, and what friction power it allows (section 5.1)."""
    force, torque = two["F_N"]["nominal"], two["M"]["nominal"]
    rig = LEVER * (48 - 100 * OFFSET)
    table = LEVER * (60 - 100 * OFFSET)
    low, high = 0.8 * torque * omega, 1.2 * torque * omega
    return {
        "rig": 100 * amplitude(100, 14, 0.41e-3, omega) / rig,
        "spring": 100 * amplitude(100, 0, 0.41e-3, omega) / rig,
        "damper": 100 * amplitude(0, 14, 0.41e-3, omega) / rig,
        "table": 100 * amplitude(100, 14, 0.7e-3, omega) / table,
        "needed": 0.2 * force / amplitude(100, 14, 1e-3, omega),
        "p_low": low, "p_high": high,
        "p_least": 0.044 * 0.8 * force * RADIUS * omega * 0.975, "p_most": 0.048 * 1.2 * force * RADIUS * omega * 1.025,
        "angle": 0.016 * omega * 180 / math.pi,
    }


def values():
    one, two = by_symbol("table1_parameters.csv"), by_symbol("table2_criteria.csv")
    three = [{k: float(v) for k, v in row.items()} for row in rows(PAPER / "table3_solutions.csv")]
    omega = two["n"]["nominal"] * math.pi / 30
    parts = {"t1": table_1(one, three), "t2": table_2(two, omega), "t3": table_3(one, two, three, omega),
             "sw": swing(two, omega)}
    return {f"{part}_{name}": value for part, found in parts.items() for name, value in found.items()}


if __name__ == "__main__":
    for name, value in values().items():
        print(name, value)
