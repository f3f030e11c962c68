"""What the stand gives: runs of the orchestrator, each the command that docs/paper.md names."""

import csv
import itertools
import json
import math
import subprocess
import tempfile
import tomllib
from pathlib import Path
from statistics import mean

from printed import COLUMNS, ROOT, rows

FMU = ROOT / "dist/PlainBearingStand.fmu"
STEADY = {"thermal.initialization": "SteadyState"}
COLD = {"thermal.initialOilTemperature": "22 degC", "thermal.initialBearingTemperature": "22 degC"}
SWINGING = {"load.eccentricity": "1.27 mm"}
ZERO = 273.15
MEAN_LOAD = "sensor.loadForceMean"
# Points for the shares of the sampled space.
MANY = 100_000
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
        self.run("verify", f"studies/{study}.toml", "--output", output, *options, codes=(0, 1))
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
    smooth = stand.simulate({"thermal.isothermal": "true", "bearing.roughness": 0}, 1, 1)[-1]
    found["smooth_power"] = smooth["sensor.frictionPowerMean"]
    found["smooth_mu"] = smooth["sensor.frictionCoefficientMean"]
    found["oil_viscosity"] = 1e3 * smooth["bearing.filmViscosity"]
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
    raw = coefficients(0)
    return {f"{name}_{key}": value for key, value in {
        "shift": 1e3 * step * best, "force": last[MEAN_LOAD], "torque": last["sensor.frictionTorqueMean"],
        "power": last["sensor.frictionPowerMean"], "mu": last["sensor.frictionCoefficientMean"],
        "bearing": last["sensor.bearingTemperatureMean"] - ZERO, "oil": last["sensor.oilTemperatureMean"] - ZERO,
        "mu_low": min(raw), "mu_high": max(raw), "power_low": min(power), "power_high": max(power),
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
    fifty, _ = stand.verify("paper-table3", "fifty")
    many, _ = stand.verify("paper-table3", "many", "--points", MANY)
    table_1, sampled = stand.verify("paper-table1", "table-1")
    _, table_3 = stand.verify("paper-table3", "rows", "--points-from", "studies/calibration-table3.csv")
    found = {"one_verified": table_1["verified"], "one_force": mean(float(row["F_N"]) for row in sampled)}
    found["wrong"] = 100 * fifty["risk"]["not_conforming_given_accepted"]
    readings = {"": lambda s: s, "abs_": lambda s: s["variants"]["absolute-bearing-tolerance"]}
    for prefix, read in readings.items():
        few, all_points = (read(summary) for summary in (fifty, many))
        for name, passed in counts(few, prefix).items():
            share = counts(all_points, prefix)[name] / MANY
            limit = {"temperatures": 37}.get(name, 10)
            found |= {f"{prefix}{name}": passed, f"{prefix}{name}_share": 100 * share,
                      f"{prefix}{name}_chance": 100 * binomial(limit, 50, share)}
    hidden = {int(row["point"]): float(row["h_mm"]) for row in rows(ROOT / "studies/calibration-table3.csv")}
    printed = {int(row["point"]): row for row in rows(ROOT / "studies/paper/table3_solutions.csv")}
    return found, [row_of_table_3(row, printed[int(row["point"])], hidden[int(row["point"])]) for row in table_3]


def counts(summary, prefix):
    if prefix:
        # A variant has no groups. All meet the oil's criterion where the bearing's is met, up to some in a thousand.
        return {"temperatures": summary["criteria"]["T_bearing"]["passed"], "all": summary["passed"]}
    groups = summary["groups"]
    return {"temperatures": groups["temperature"]["passed"], "loads": groups["power-and-load"]["passed"],
            "all": summary["verified"]}


def binomial(most, count, share):
    """How probable a count as far from its mean, or farther on that side, is."""
    chances = [math.comb(count, k) * share**k * (1 - share) ** (count - k) for k in range(count + 1)]
    return sum(chances[: most + 1]) if most < count * share else sum(chances[most:])


def row_of_table_3(row, printed, h):
    off = {name: float(row[name]) - float(printed[column]) for name, column in
           {"F_N": "F_N_N", "P_fr": "P_fr_W", "T_oil": "T_oil_degC", "T_bearing": "T_bearing_degC"}.items()}
    share = 100 * off["P_fr"] / float(printed["P_fr_W"])
    judged = "yes" if row["verified"] == "true" else "no: " + ", ".join(n for n in off if row[f"{n}.ok"] == "false")
    return (f"| {row['point']} | {h:.4f} | {off['F_N']:+.2f} | {share:+.2f} | {off['T_oil']:+.3f} "
            f"| {off['T_bearing']:+.3f} | {judged} |")


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
    beside, alone = [], []
    for index, pair in enumerate(maps):
        field = temperatures[index * side**2: (index + 1) * side**2]
        cells = [field[i * side: (i + 1) * side] for i in range(side)]
        if clearance in pair:
            # The clearance is the first parameter: columns have one clearance each.
            alone.append(max(max(column) - min(column) for column in zip(*cells)))
            beside.append(max(max(row) - min(row) for row in cells))
            continue
        inner = [value for row in cells[1:-1] for value in row[1:-1]]
        edge = [value for i, row in enumerate(cells) for j, value in enumerate(row) if {i, j} & {0, side - 1}]
        extremes += max(inner) > max(edge) + LEAST_EXTREME or min(inner) < min(edge) - LEAST_EXTREME
        others += 1
    return {"pairs": others, "extremes": extremes, "by_h": max(alone), "beside_h": max(beside)}


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
    return flat | {"table_3": "\n".join(table)}
