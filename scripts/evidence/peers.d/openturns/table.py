"""Runs the points of a table through an FMU with OpenTURNS and FMPy: FMU POINTS.csv RESULTS.csv STOP STEP PROCESSES OUTPUT..."""
import sys

import openturns as ot
from fmpy import extract, instantiate_fmu, read_model_description, simulate_fmu

source, table, target, stop, step, processes, *outputs = sys.argv[1:]
points = ot.Sample.ImportFromCSVFile(table, ",")
folder = extract(source)
description = read_model_description(folder)
fmu = instantiate_fmu(folder, description, "CoSimulation")


def simulate(values):
    try:
        fmu.reset()
        result = simulate_fmu(folder, model_description=description, fmu_instance=fmu, stop_time=stop,
                              output_interval=float(step), start_values=dict(zip(points.getDescription(), values)),
                              output=outputs)
        return [result[name][-1] for name in outputs]
    except Exception as error:
        print(error, file=sys.stderr)
        return [float("nan")] * len(outputs)


model = ot.PythonFunction(points.getDimension(), len(outputs), simulate, n_cpus=int(processes))
results = model(points)
results.setDescription(outputs)
results.exportToCSVFile(target, ",")
