"""What the stand gives: runs of the orchestrator, each the command that docs/paper.md names."""

import cmath
import csv
import itertools
import json
import math
import subprocess
import tempfile
import tomllib
from pathlib import Path
from statistics import mean

from printed import COLUMNS, ROOT, aligned, rows, table_3_lines

FMU = ROOT / "dist/PlainBearingStand.fmu"
STEADY = {"thermal.initialization": "SteadyState"}
COLD = {"thermal.initialOilTemperature": "22 degC", "thermal.initialBearingTemperature": "22 degC"}
SWINGING = {"load.eccentricity": "1.27 mm"}
FLUCTUATING = {"drive.fluctuationAmplitude": "2.5 %"}
ZERO = 273.15
MEAN_LOAD = "sensor.loadForceMean"
# Points for the shares of the sampled space, and of Table 1's.
MANY = 100_000
MANY_OF_TABLE_1 = 2000
# Seeds of each design that the paper names.
SEEDS = 10
# Steps over which a pair of parameters goes from two deviations below its mean to two above.
STEPS = 6
# An extreme within a map counts from this, K.
LEAST_EXTREME = 1e-3


class Stand:
    def __init__(self, program, folder):
        self.program, self.folder = program, Path(folder)

    def run(self, *arguments, codes=(0,)):
        done = subprocess.run([self.program, *map(str, arguments)], cwd=ROOT, capture_output=True, text=True)
        if done.returncode not in codes:
            raise SystemExit(f"{' '.join(map(str, arguments))}\n{done.stderr}")
        return done.stdout

    def simulate(self, settings, stop, step):
        pairs = itertools.chain.from_iterable(("--set", f"{name}={value}") for name, value in settings.items())
        printed = self.run("simulate", FMU, "--stop", stop, "--step", step, *pairs)
        return [{k: float(v) for k, v in row.items()} for row in csv.DictReader(printed.splitlines())]

    def verify(self, study, name, *options):
        output = self.folder / name
        self.run("verify", ROOT / "studies" / f"{study}.toml", "--output", output, *options, codes=(0, 1))
        points = [row for row in rows(output / "points.csv") if not row["point"].startswith("#")]
        return json.loads((output / "summary.json").read_text(encoding="utf-8")), points

    def indices(self, study, base):
        """First and total Sobol indices by output and parameter."""
        output = self.folder / f"sensitivity-{study}"
        self.run("sensitivity", f"studies/{study}.toml", "--base", base, "--output", output)
        found = json.loads((output / "sensitivity.json").read_text(encoding="utf-8"))
        return {one["name"]: {kind: dict(zip(found["parameters"], (index["value"] for index in one["sobol"][kind])))
                              for kind in ("first", "total")} for one in found["outputs"]}


def rig(stand):
    """One turn of the rig in its steady state, and the delay of the torque that makes mu steadiest."""
    found = turn(stand, "rig", {})
    found |= turn(stand, "wide", SWINGING)
    # Two seconds are the fluctuation's period.
    power = [row["sensor.frictionPower"] for row in stand.simulate(STEADY | SWINGING | FLUCTUATING, 2, 1e-3)]
    found |= {"fluctuating_low": min(power), "fluctuating_high": max(power)}
    smooth = stand.simulate({"thermal.isothermal": "true", "bearing.roughness": 0}, 1, 1)[-1]
    found["smooth_power"] = smooth["sensor.frictionPowerMean"]
    found["smooth_mu"] = smooth["sensor.frictionCoefficientMean"]
    found["oil_viscosity"] = 1e3 * smooth["bearing.filmViscosity"]
    for clearance in (10, 15, 25, 30):
        last = stand.simulate(STEADY | {"bearing.radialClearance": f"{clearance} um"}, 0.2, 0.2)[-1]
        found[f"bearing_{clearance}"] = last["sensor.bearingTemperatureMean"] - ZERO
        found[f"mu_{clearance}"] = last["sensor.frictionCoefficientMean"]
    return found


def turn(stand, name, settings):
    step, turn = 2.5e-4, 800
    way = stand.simulate(STEADY | settings, 1, step)[-turn:]
    force, torque, power = ([row[f"sensor.{one}"] for row in way] for one in ("loadForce", "frictionTorque", "frictionPower"))
    last = way[-1]

    def coefficients(shift):
        return [torque[(i + shift) % turn] / (force[i] * 0.0125) for i in range(turn)]

    def variance(shift):
        values = coefficients(shift)
        centre = mean(values)
        return sum((value - centre) ** 2 for value in values)

    best = min(range(-turn // 4, turn // 4), key=variance)
    raw, shifted = coefficients(0), coefficients(best)
    first, second = (abs(sum(m * cmath.exp(-2j * math.pi * k * i / turn) for i, m in enumerate(torque))) for k in (1, 2))
    return {f"{name}_{key}": value for key, value in {
        "shift": 1e3 * step * best, "force": last[MEAN_LOAD], "torque": last["sensor.frictionTorqueMean"],
        "power": last["sensor.frictionPowerMean"], "mu": last["sensor.frictionCoefficientMean"],
        "bearing": last["sensor.bearingTemperatureMean"] - ZERO, "oil": last["sensor.oilTemperatureMean"] - ZERO,
        "mu_low": min(raw), "mu_high": max(raw), "mu_least": min(shifted), "mu_most": max(shifted),
        "second": 100 * second / first, "power_low": min(power), "power_high": max(power),
        "constant": last["thermal.slowestTimeConstant"], "bath": last["thermal.oilBathCapacity"],
        "share": 100 * last["bearing.contactShare"]}.items()}


def long_run(stand):
    """5,000 s from 22 degC: where the bush comes to, the load that brings it to 120 degC, and the heat capacities with which it
    comes within Table 2's limits."""
    def end(capacity, extra):
        masses = {"thermal.bushCapacity": capacity, "thermal.shaftCapacity": capacity}
        return stand.simulate(COLD | masses | {"load.externalForce": extra}, 5000, 5000)[-1]

    def bush(capacity, extra):
        return end(capacity, extra)["sensor.bearingTemperatureMean"] - ZERO

    found = {}
    for capacity in (200, 50, 20):
        extra = first(lambda extra: bush(capacity, extra) >= 120, 0, 3000, 0.5)
        found[f"bush_{capacity}"] = bush(capacity, 0)
        found[f"load_{capacity}"] = end(capacity, extra)[MEAN_LOAD]
    found["most"] = first(lambda capacity: bush(capacity, 0) < 82 * 0.9925, 1, 200, 0.1)
    return found


def first(holds, low, high, close):
    """Where a condition begins to hold between two numbers, within `close`."""
    while high - low > close:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def studies(stand):
    """The paper's 50 points, many more of them, the rows of Table 3, and Table 1 as printed."""
    fifty, drawn = stand.verify("paper-table3", "fifty")
    many, all_drawn = stand.verify("paper-table3", "many", "--points", MANY)
    table_1, _ = stand.verify("paper-table1", "table-1")
    _, table_3 = stand.verify("paper-table3", "rows", "--points-from", "studies/calibration-table3.csv")
    more, sampled = stand.verify("paper-table1", "table-1-more", "--points", MANY_OF_TABLE_1)
    share = more["verified_fraction"]
    found = {"one_verified": table_1["verified"], "one_share": 100 * share, "one_none": 100 * (1 - share) ** 50,
             "one_force": mean(float(row["F_N"]) for row in sampled)}
    found |= dict(zip(("one_low", "one_high"), (100 * limit for limit in more["verified_interval"]))) | designs(stand)
    found["not"] = ", ".join(row["point"] for row in table_3 if row["verified"] != "true")
    found["wrong"] = 100 * fifty["risk"]["not_conforming_given_accepted"]
    temperatures = [float(row["T_bearing"]) for row in drawn]
    clearances = [float(row["bearing.radialClearance"]) for row in drawn if row["T_bearing.ok"] == "true"]
    found |= {"coldest": min(temperatures), "hottest": max(temperatures), "h_from": min(clearances), "h_to": max(clearances)}
    found |= robust_range(stand)
    for prefix, count, few, all_points in (("", counts, fifty, many), ("abs_", absolute, drawn, all_drawn)):
        for name, passed in count(few).items():
            share = count(all_points)[name] / MANY
            limit = {"temperatures": 37}.get(name, 10)
            found |= {f"{prefix}{name}": passed, f"{prefix}{name}_share": 100 * share,
                      f"{prefix}{name}_chance": 100 * binomial(limit, 50, share)}
    return found, compared_with_table_3(table_3)


def designs(stand):
    """The fewest and the most of 50 points that the designs of step 2 verify."""
    text = (ROOT / "studies/paper-table3.toml").read_text(encoding="utf-8").replace('"../dist/', f'"{ROOT}/dist/')
    found = {}
    for method in ("monte-carlo", "latin-hypercube", "sobol"):
        (stand.folder / f"{method}.toml").write_text(text.replace('"monte-carlo"', f'"{method}"'), encoding="utf-8")
        passed = [stand.verify(stand.folder / method, f"{method}-{seed}", "--seed", seed)[0]["verified"]
                  for seed in range(1, SEEDS + 1)]
        found |= {f"{method}_least": min(passed), f"{method}_most": max(passed)}
    return found


def robust_range(stand):
    """The largest box that `robustness` finds from the 50 points, and how many of 1,000 new points in it are verified."""
    stand.run("robustness", "studies/paper-table3.toml", "--from", stand.folder / "fifty", "--output", stand.folder / "robust",
              "--confirm", 1000)
    found = json.loads((stand.folder / "robust" / "robustness.json").read_text(encoding="utf-8"))
    region = found["region"]
    limits = dict(zip(found["parameters"], region["limits"]))
    sides = {"h": limits["bearing.radialClearance"], "F0": limits["load.preload"]}
    return {f"box_{name}_{end}": value for name, both in sides.items() for end, value in zip(("from", "to"), both)} | {
        "box_share": 100 * region["share"], "box_verified": region["fresh"]["verified"]}


def absolute(points):
    """Counts with the bearing's temperature within 0.75 degC, in place of 0.75 %."""
    near = [row for row in points if abs(float(row["T_bearing"]) - 82) <= 0.75]
    others = [row for row in near if all(row[f"{name}.ok"] == "true" for name in ("T_oil", "F_N", "P_fr"))]
    # All meet the oil's criterion where the bearing's is met, up to some in a thousand.
    return {"temperatures": len(near), "all": len(others)}


def counts(summary):
    groups = summary["groups"]
    return {"temperatures": groups["temperature"]["passed"], "loads": groups["power-and-load"]["passed"],
            "all": summary["verified"]}


def binomial(most, count, share):
    """How probable a count as far from its mean, or farther on that side, is."""
    chances = [math.comb(count, k) * share**k * (1 - share) ** (count - k) for k in range(count + 1)]
    return sum(chances[: most + 1]) if most < count * share else sum(chances[most:])


def compared_with_table_3(points):
    """The block of Table 3: clearances, and what the stand gives less what is printed."""
    printed = rows(ROOT / "studies/paper/table3_solutions.csv")

    def off(name, column):
        return [float(ours[name]) - float(row[column]) for ours, row in zip(points, printed, strict=True)]

    shares = [100 * power / float(row["P_fr_W"]) for power, row in zip(off("P_fr", "P_fr_W"), printed)]
    lines = [aligned("F_N, N", (f"{value:+.2f}" for value in off("F_N", "F_N_N"))),
             aligned("P_fr, %", (f"{value:+.2f}" for value in shares))]
    lines += [aligned(f"{name}, K", (f"{value:+.3f}" for value in off(name, f"{name}_degC"))) for name in ("T_oil", "T_bearing")]
    return "\n".join(table_3_lines() + lines)


def pairs(stand):
    """Maps of T_bearing over pairs of parameters, the others at their means: Table 4 with Table 3's model and on the rig."""
    found = {}
    for study, name in (("paper-table3", "a"), ("rig", "b")):
        with open(ROOT / "studies" / f"{study}.toml", "rb") as file:
            parameters = tomllib.load(file)["parameters"]
        maps, points = grids(parameters)
        table = stand.folder / f"pairs-{name}.csv"
        with open(table, "w", newline="", encoding="utf-8") as out:
            writer = csv.writer(out)
            writer.writerow(["point", *(p.get("column", variable) for variable, p in parameters.items())])
            writer.writerows([i, *point] for i, point in enumerate(points))
        _, answers = stand.verify(study, f"pairs-{name}", "--points-from", table)
        found |= {f"{name}_{key}": value for key, value in look(maps, [float(row["T_bearing"]) for row in answers]).items()}
    return found


def varied(parameters):
    """Mean and deviation of the bearing's and the load's parameters."""
    return {name: (p["mean"], p["deviation"]) for name, p in parameters.items()
            if name.startswith(("bearing.", "load.")) and name != "bearing.bushExpansion"}


def grids(parameters):
    centre = {name: p.get("mean", p.get("mode")) for name, p in parameters.items()}
    places = {name: [m + d * (4 * i / STEPS - 2) for i in range(STEPS + 1)] for name, (m, d) in varied(parameters).items()}
    maps = list(itertools.combinations(places, 2))
    points = [list((centre | {one: x, other: y}).values())
              for one, other in maps for x in places[one] for y in places[other]]
    return maps, points


def look(maps, temperatures):
    side = STEPS + 1
    clearance, others, extremes = "bearing.radialClearance", 0, 0
    beside, alone, widths, hot, cold = [], [], [], [], []
    for index, pair in enumerate(maps):
        field = temperatures[index * side**2: (index + 1) * side**2]
        cells = [field[i * side: (i + 1) * side] for i in range(side)]
        if "bearing.width" in pair:
            lines = cells if pair[1] == "bearing.width" else zip(*cells)
            widths += [line[-1] - line[0] for line in lines]
        if clearance in pair:
            # The clearance is the first parameter: rows have one clearance each.
            alone.append(max(max(column) - min(column) for column in zip(*cells)))
            beside.append(max(max(row) - min(row) for row in cells))
            continue
        inner = [value for row in cells[1:-1] for value in row[1:-1]]
        edge = [value for i, row in enumerate(cells) for j, value in enumerate(row) if {i, j} & {0, side - 1}]
        extremes += max(inner) > max(edge) + LEAST_EXTREME or min(inner) < min(edge) - LEAST_EXTREME
        hot.append(max(field))
        cold.append(min(field))
        others += 1
    return {"pairs": others, "extremes": extremes, "by_h": max(alone), "beside_h": max(beside), "coldest": min(cold),
            "hottest": max(hot), "width_low": min(widths), "width_high": max(widths)}


def inside(stand):
    """In how many planes without h the hottest or the coldest of the 50 points lies within the cloud."""
    points = [row for row in rows(stand.folder / "fifty" / "points.csv") if not row["point"].startswith("#")]
    names = [name for name in points[0] if name.startswith(("bearing.", "load.")) and name != "bearing.radialClearance"]
    temperature = [float(row["T_bearing"]) for row in points]
    extremes = [temperature.index(pick(temperature)) for pick in (min, max)]
    planes = list(itertools.combinations(names, 2))
    within = 0
    for one, other in planes:
        cloud = [(float(row[one]), float(row[other])) for row in points]
        within += any(cloud[i] not in hull(cloud) for i in extremes)
    return {"planes": len(planes), "within": within}


def hull(points):
    """Corners of the convex hull (Andrew's monotone chain)."""
    def half(points):
        chain = []
        for x, y in points:
            while len(chain) > 1 and ((chain[-1][0] - chain[-2][0]) * (y - chain[-2][1])
                                      <= (chain[-1][1] - chain[-2][1]) * (x - chain[-2][0])):
                chain.pop()
            chain.append((x, y))
        return chain
    ordered = sorted(points)
    return set(half(ordered)) | set(half(ordered[::-1]))


def influence(stand):
    """Sobol indices: which parameter matters (section 6, Table 5)."""
    found = {}
    for study, base, name in (("paper-table3", 1024, "a"), ("rig", 256, "b")):
        outputs = stand.indices(study, base)
        for output in ("T_bearing", "P_fr", "F_N"):
            for variable in COLUMN_OF:
                found |= {f"{name}_{output}_{COLUMN_OF[variable]}": outputs[output]["total"][variable]}
        verdict = outputs["verified"]["total"]
        found |= {f"{name}_verdict_{COLUMN_OF[variable]}": verdict[variable] for variable in COLUMN_OF}
        found[f"{name}_verdict_most"] = max(verdict[v] for v, symbol in COLUMN_OF.items() if symbol not in ("h", "F0"))
        found[f"{name}_first"] = outputs["T_bearing"]["first"]["bearing.radialClearance"]
    return found


VARIABLES = ["bearing.radialClearance", "load.stiffness", "load.damping", "load.preload", "load.eccentricity",
             "bearing.width", "bearing.diameter"]
COLUMN_OF = dict(zip(VARIABLES, COLUMNS))


def settling(stand):
    """The paper's model after 150 s and in its steady state, at the means of paper-table3.toml."""
    with open(ROOT / "studies/paper-table3.toml", "rb") as file:
        fixed = {name: str(value) for name, value in tomllib.load(file)["fixed"].items()}
    short = stand.simulate(fixed, 150, 150)[-1]
    steady = stand.simulate(fixed | STEADY, 0.2, 0.2)[-1]
    return {name: run["sensor.bearingTemperature"] - ZERO for name, run in {"short": short, "steady": steady}.items()}


PARTS = {"rig": rig, "run": long_run, "map": pairs, "s": influence, "a": settling}


def values(program):
    with tempfile.TemporaryDirectory() as folder:
        stand = Stand(program, folder)
        found, table = studies(stand)
        parts = {"st": found, "in": inside(stand)} | {name: part(stand) for name, part in PARTS.items()}
    flat = {f"{part}_{name}": value for part, group in parts.items() for name, value in group.items()}
    return flat | {"table_3": table}
