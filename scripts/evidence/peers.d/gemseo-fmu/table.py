"""Runs the points of a table through an FMU with gemseo-fmu: FMU POINTS.csv RESULTS.csv STOP STEP PROCESSES OUTPUT..."""
import csv
import sys

from fmpy.fmi1 import FMICallException
from gemseo import sample_disciplines
from gemseo.algos.design_space import DesignSpace
from gemseo_fmu.disciplines.fmu_discipline import FMUDiscipline
from numpy import array


class Guarded(FMUDiscipline):
    def _run(self, input_data):
        try:
            return super()._run(input_data)
        except FMICallException as error:  # GEMSEO skips a point that raises a ValueError, and no other
            raise ValueError(str(error)) from error


source, table, target, stop, step, processes, *outputs = sys.argv[1:]
with open(table) as lines:
    names, *rows = csv.reader(lines)
points = array(rows, dtype=float)
space = DesignSpace()
for name, lower, upper in zip(names, points.min(axis=0), points.max(axis=0)):
    space.add_variable(name, lower_bound=lower, upper_bound=upper)
discipline = Guarded(source, names, outputs, final_time=float(stop), time_step=float(step),
                     add_time_to_output_grammar=False)
data = sample_disciplines([discipline], space, outputs, algo_name="CustomDOE", samples=points, n_processes=int(processes))
with open(target, "w") as file:
    csv.writer(file).writerow(outputs)
    csv.writer(file).writerows(zip(*(data.get_view(variable_names=name).to_numpy()[:, -1] for name in outputs)))
