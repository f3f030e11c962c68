"""Runs the points of a table through an FMU with FMPy: FMU POINTS.csv RESULTS.csv STOP STEP PROCESSES OUTPUT..."""
import csv
import sys
from concurrent.futures import ProcessPoolExecutor

from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu

source, table, target, stop, step, processes, *outputs = sys.argv[1:]
with open(table) as lines:
    points = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(lines)]
folder = extract(source)
description = read_model_description(folder)
fmu = instantiate_fmu(folder, description, "CoSimulation")


def simulate(values):
    try:
        fmu.reset()
        result = simulate_fmu(folder, model_description=description, fmu_instance=fmu, stop_time=stop,
                              output_interval=float(step), start_values=values, output=outputs)
        return [result[name][-1] for name in outputs]
    except Exception as error:
        print(error, file=sys.stderr)
        return [float("nan")] * len(outputs)


if processes == "1":
    results = list(map(simulate, points))
else:
    with ProcessPoolExecutor(int(processes)) as pool:
        results = list(pool.map(simulate, points))
with open(target, "w") as file:
    csv.writer(file).writerows([outputs, *results])
