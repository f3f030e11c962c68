"""estim8, parameter estimation."""

from estim8.models import FmuModel
from scenario import FMU, OUTPUTS, START, STEP, STOP, report


class Model(FmuModel):
    """estim8 reads the start of every parameter as a number, which Booleans and Strings have not."""

    def retrieve_variables(self):
        variables = self._model_description.modelVariables
        self.parameters = {v.name: float(v.start) for v in variables
                           if v.initial == "exact" and v.type == "Real"}
        self.observables = [v.name for v in variables if v.causality == "output"]


model = Model(FMU, fmi_type="CoSimulation")
result = model.simulate(t0=0.0, t_end=STOP, stepsize=STEP, parameters=START, observe=OUTPUTS,
                        r_tol=1e-6)
report("estim8", list(zip(*(result[name].values for name in OUTPUTS))),
       "we replace its code that reads Boolean and String parameters as numbers")
