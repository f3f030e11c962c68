//! Derivatives over time: of inputs, which the host gives, and of outputs.

use super::{
    instance::Instance,
    refusal::{Outcome, Refusal},
    types::{Real, Status, ValueReference},
    values::variable,
};
use crate::model::{Kind, Model, Role, Variable};

/// Step of the one-sided difference over time, relative to the suggested communication step.
const TIME_STEP: f64 = 1e-3;

impl<M: Model> Instance<M> {
    /// Sets the rates of inputs. The slopes hold for the next step.
    pub fn set_input_derivatives(&mut self, references: &[ValueReference], orders: &[i32], values: &[Real]) -> Outcome {
        let slopes = references
            .iter()
            .zip(orders)
            .zip(values)
            .map(|((reference, order), value)| {
                let variable = variable::<M>(*reference)?;
                let set = input_slope(variable, *order)?;
                if !value.is_finite() {
                    return Err(unfit(variable, format!("its derivative, {value}, must be finite")));
                }
                Ok((set, *value))
            })
            .collect::<Outcome<Vec<_>>>()?;
        let model = self.run.seed.as_mut().unwrap_or(&mut self.run.model);
        for (set, value) in slopes {
            set(model, value);
        }
        self.run.sloped |= !references.is_empty();
        self.run.differentiated = false;
        Ok(Status::Ok)
    }

    /// Sets the slopes back to zero after a step.
    pub fn clear_slopes(&mut self) {
        if !std::mem::take(&mut self.run.sloped) {
            return;
        }
        for variable in M::variables() {
            if let Kind::Real(real) = &variable.kind
                && let Some(set) = real.slope
            {
                set(&mut self.run.model, 0.0);
            }
        }
    }

    /// The rates of outputs: from the model if it knows the derivative, else a one-sided difference of second
    /// order, for which a copy of the model is stepped a little ahead.
    pub fn get_output_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[i32],
        values: &mut [Real],
    ) -> Outcome {
        self.refresh()?;
        let mut ahead = None;
        for ((reference, order), value) in references.iter().zip(orders).zip(values.iter_mut()) {
            let (read, derivative) = output(variable::<M>(*reference)?, *order)?;
            *value = match derivative {
                Some(derivative) => derivative(self.differentiated()?),
                None => {
                    let [near, far] = match &mut ahead {
                        Some(ahead) => ahead,
                        None => ahead.insert(self.go_ahead()?),
                    };
                    let [here, near, far] = [&self.run.model, near, far].map(read);
                    (4.0 * near - 3.0 * here - far) / (2.0 * TIME_STEP * M::INFO.default_step)
                }
            };
        }
        bounded(values)
    }

    /// The model with its outputs' rates computed, once for all outputs.
    fn differentiated(&mut self) -> Outcome<&M> {
        if !self.run.differentiated {
            self.run.model.differentiate().map_err(Refusal::Step)?;
            self.run.differentiated = true;
        }
        Ok(&self.run.model)
    }

    /// Copies of the model one and two short steps ahead.
    fn go_ahead(&self) -> Outcome<[M; 2]> {
        let (time, step) = (self.run.time, TIME_STEP * M::INFO.default_step);
        let mut near = self.run.model.clone();
        near.advance(time, step, &mut ()).map_err(Refusal::Step)?;
        let mut far = near.clone();
        far.advance(time + step, step, &mut ()).map_err(Refusal::Step)?;
        Ok([near, far])
    }
}

/// Refuses derivatives that overflow.
fn bounded(values: &[Real]) -> Outcome {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(Status::Ok);
    }
    Err(Refusal::Unsupported("a derivative overflows"))
}

type Read<M> = fn(&M) -> f64;
type Slope<M> = fn(&mut M, f64);

fn output<M>(variable: &'static Variable<M>, order: i32) -> Outcome<(Read<M>, Option<Read<M>>)> {
    check_order(variable, order)?;
    match (&variable.kind, variable.role) {
        (Kind::Real(real), Role::Output) => Ok((real.access.get, real.derivative)),
        _ => Err(unfit(variable, "only Real outputs have time derivatives".to_owned())),
    }
}

fn input_slope<M>(variable: &'static Variable<M>, order: i32) -> Outcome<Slope<M>> {
    check_order(variable, order)?;
    let slope = match &variable.kind {
        Kind::Real(real) => real.slope,
        _ => None,
    };
    let why = "only inputs that may vary within a step take time derivatives";
    slope.ok_or_else(|| unfit(variable, why.to_owned()))
}

fn check_order<M>(variable: &Variable<M>, order: i32) -> Outcome<()> {
    if order == 1 {
        return Ok(());
    }
    Err(unfit(variable, format!("the order of a time derivative must be 1, not {order}")))
}

fn unfit<M>(variable: &Variable<M>, why: String) -> Refusal {
    Refusal::Derivative { name: variable.name, why }
}

#[cfg(test)]
mod tests {
    use std::ptr::null_mut;

    use serde::{Deserialize, Serialize};

    use super::*;
    use crate::boundary::logger::Logger;
    use crate::boundary::version::Version;
    use crate::declare::{input, output};
    use crate::model::{Experiment, Fault, Info, Log};
    use crate::{field, units};

    /// A model that counts how often it computes its rates; it has none where its input is negative.
    #[derive(Clone, Default, Serialize, Deserialize)]
    struct Counting {
        input: f64,
        slope: f64,
        count: f64,
    }

    static VARIABLES: [Variable<Counting>; 3] = [
        input("input", &units::ONE, field!(Counting: input), "An input").slope(|counting, rate| counting.slope = rate),
        output("one", &units::ONE, |counting: &Counting| counting.input, "An output")
            .derivative(|counting| counting.count),
        output("two", &units::ONE, |counting: &Counting| counting.input, "Another")
            .derivative(|counting| counting.count),
    ];

    impl Model for Counting {
        const INFO: Info = crate::info!();

        fn variables() -> &'static [Variable<Self>] {
            &VARIABLES
        }

        fn initialise(&mut self, _: &Experiment<'_>, _: &mut dyn Log) -> Result<(), Fault> {
            Ok(())
        }

        fn differentiate(&mut self) -> Result<(), Fault> {
            if self.input < 0.0 {
                return Err(Fault::Failed("there are none".to_owned()));
            }
            self.count += 1.0;
            Ok(())
        }

        fn advance(&mut self, _: f64, _: f64, _: &mut dyn Log) -> Result<(), Fault> {
            Ok(())
        }
    }

    fn started(version: Version) -> Outcome<Instance<Counting>> {
        let logger = Logger::new(None, null_mut(), false);
        let mut instance = Instance::<Counting>::new("instantiate", (version, false), 0, None, logger);
        instance.enter_initialization()?;
        instance.exit_initialization()?;
        Ok(instance)
    }

    #[test]
    fn rates_that_cannot_be_computed_are_discarded() -> Outcome<()> {
        for version in [Version::Two, Version::Three] {
            let mut instance = started(version)?;
            instance.set_real(&[0], &[-1.0])?;
            let mut rates = [7.0];
            for _ in 0..2 {
                let refusal = instance.get_output_derivatives(&[1], &[1], &mut rates);
                let refusal = refusal.unwrap_err();
                assert_eq!(refusal.status(), Status::Discard, "{refusal}");
                assert_eq!(refusal.to_string(), "there are none");
            }
            instance.set_real(&[0], &[1.0])?;
            instance.get_output_derivatives(&[1], &[1], &mut rates)?;
            assert_eq!(rates, [1.0]);
        }
        Ok(())
    }

    #[test]
    fn rates_are_computed_once_until_something_changes() -> Outcome<()> {
        let mut instance = started(Version::Two)?;
        let mut rates = [0.0; 2];
        instance.get_output_derivatives(&[1, 2], &[1, 1], &mut rates)?;
        assert_eq!(rates, [1.0, 1.0]);
        instance.get_output_derivatives(&[2], &[1], &mut rates[..1])?;
        assert_eq!(rates[0], 1.0, "nothing has changed");
        let changes: [fn(&mut Instance<Counting>) -> Outcome; 3] = [
            |instance| instance.set_real(&[0], &[5.0]),
            |instance| instance.set_input_derivatives(&[0], &[1], &[2.0]),
            |instance| instance.step(0.0, 1.0),
        ];
        for (change, count) in changes.into_iter().zip([2.0, 3.0, 4.0]) {
            change(&mut instance)?;
            instance.get_output_derivatives(&[1, 2], &[1, 1], &mut rates)?;
            assert_eq!(rates, [count; 2]);
        }
        Ok(())
    }
}
