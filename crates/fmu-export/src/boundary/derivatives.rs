//! Derivatives: of inputs over time, which the host gives, of outputs over time, and directional ones of unknowns with
//! respect to knowns.

use super::{
    instance::Instance,
    lookup::variable_of,
    phase::Phase,
    refusal::{Outcome, Refusal},
    types::{Real, ValueReference},
    values::check_settable,
};
use crate::model::{Kind, Model, Role, Variable, inside};

/// Step of the central difference, relative to a variable's magnitude: at the cube root of the rounding unit, truncation
/// and rounding errors are of the same size (Press et al., Numerical Recipes, 2007, section 5.7).
const RELATIVE_STEP: f64 = 6.055e-6;

/// Step of the one-sided difference over time, relative to the suggested communication step.
const TIME_STEP: f64 = 1e-3;

/// A known of a directional derivative: a real variable that the host may set.
struct KnownVariable<M: 'static> {
    set: fn(&mut M, &f64),
    value: f64,
    direction: f64,
    magnitude: f64,
    min: Option<f64>,
    max: Option<f64>,
}

impl<M: Model> Instance<M> {
    /// Sets the rates of inputs. The slopes hold for the next step.
    pub fn set_input_derivatives(&mut self, references: &[ValueReference], orders: &[i32], values: &[Real]) -> Outcome {
        let slopes = references
            .iter()
            .zip(orders)
            .zip(values)
            .map(|((reference, order), value)| {
                let variable = variable_of::<M>(*reference)?;
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
        Ok(())
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
        self.check_intermediate(references, false)?;
        self.refresh()?;
        let mut ahead = None;
        for ((reference, order), value) in references.iter().zip(orders).zip(values.iter_mut()) {
            let (read, derivative) = output(variable_of::<M>(*reference)?, *order)?;
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

    /// The directional derivative: the central difference along the direction, on copies of the model. Near a bound
    /// of a known it is one-sided, of second order.
    pub fn get_directional_derivative(
        &mut self,
        unknowns: &[ValueReference],
        knowns: &[ValueReference],
        direction: &[Real],
        values: &mut [Real],
    ) -> Outcome {
        if self.run.exchange && self.run.phase == Phase::Event {
            return Err(Refusal::Phase(self.run.phase));
        }
        self.refresh()?;
        let reads = unknowns.iter().map(|unknown| read(variable_of::<M>(*unknown)?)).collect::<Outcome<Vec<_>>>()?;
        let knowns = knowns
            .iter()
            .zip(direction)
            .map(|(known, direction)| self.known(variable_of::<M>(*known)?, *direction))
            .collect::<Outcome<Vec<_>>>()?;
        let rate = knowns.iter().fold(0.0_f64, |rate, known| rate.max((known.direction / known.magnitude).abs()));
        if rate == 0.0 {
            values.fill(0.0);
            return Ok(());
        }
        let step = RELATIVE_STEP / rate;
        values.fill(0.0);
        for (offset, weight) in stencil(&knowns, step) {
            let model = self.variant(|model| {
                for known in &knowns {
                    (known.set)(model, &known.at(offset * step));
                }
            })?;
            for (value, read) in values.iter_mut().zip(&reads) {
                *value += weight * read(&model) / step;
            }
        }
        bounded(values)
    }

    /// The adjoint derivative: for each known, the sum of the unknowns' derivatives with respect to it, each times its
    /// component of `seed`.
    pub fn get_adjoint_derivative(
        &mut self,
        unknowns: &[ValueReference],
        knowns: &[ValueReference],
        seed: &[Real],
        values: &mut [Real],
    ) -> Outcome {
        if let Some(seed) = seed.iter().find(|seed| !seed.is_finite()) {
            return Err(Refusal::Argument { name: "seed", value: format!("{seed:?}"), why: "it must be finite" });
        }
        let mut column = vec![0.0; unknowns.len()];
        for (known, value) in knowns.iter().zip(values.iter_mut()) {
            self.get_directional_derivative(unknowns, &[*known], &[1.0], &mut column)?;
            *value = column.iter().zip(seed).map(|(one, seed)| one * seed).sum();
        }
        bounded(values)
    }

    fn known(&self, variable: &'static Variable<M>, direction: f64) -> Outcome<KnownVariable<M>> {
        // A known must be settable: in initialization as now, otherwise as at a communication point, also after the end.
        let phase = match self.run.phase {
            Phase::Initialization => Phase::Initialization,
            _ => Phase::StepComplete,
        };
        check_settable(variable, phase)?;
        let settable = match &variable.kind {
            Kind::Real(real) => real.access.set.map(|set| (real, set)),
            _ => None,
        };
        let Some((real, set)) = settable else {
            return Err(unfit(
                variable,
                format!("only a Real that can be set can be a known, not a variable of type {}", variable.type_name()),
            ));
        };
        if !direction.is_finite() {
            return Err(unfit(variable, format!("its component of the direction, {direction}, must be finite")));
        }
        let value = (real.access.get)(self.run.seed.as_ref().unwrap_or(&self.run.model));
        let magnitude = match (value.abs(), real.nominal) {
            (value, Some(nominal)) => value.max(nominal.abs()),
            (0.0, None) => 1.0,
            (value, None) => value,
        };
        Ok(KnownVariable { set, value, direction, magnitude, min: real.min, max: real.max })
    }
}

/// Refuses derivatives that overflow, as they do along directions of 1e300.
fn bounded(values: &[Real]) -> Outcome {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(());
    }
    Err(Refusal::Unsupported("a derivative overflows"))
}

impl<M> KnownVariable<M> {
    fn at(&self, distance: f64) -> f64 {
        self.value + distance * self.direction
    }
}

/// Offsets, in steps, with their weights: a central difference if all knowns stay within their bounds, else one ahead or
/// back.
fn stencil<M>(knowns: &[KnownVariable<M>], step: f64) -> &'static [(f64, f64)] {
    let fits = |offset: f64| knowns.iter().all(|known| inside(known.at(offset * step), known.min, known.max));
    match (fits(-1.0), fits(1.0)) {
        (false, true) if fits(2.0) => &[(0.0, -1.5), (1.0, 2.0), (2.0, -0.5)],
        (true, false) if fits(-2.0) => &[(0.0, 1.5), (-1.0, -2.0), (-2.0, 0.5)],
        _ => &[(1.0, 0.5), (-1.0, -0.5)],
    }
}

type Read<M> = fn(&M) -> f64;
type Slope<M> = fn(&mut M, f64);

fn read<M>(variable: &'static Variable<M>) -> Outcome<Read<M>> {
    match (&variable.kind, variable.role) {
        (Kind::Real(real), Role::Output | Role::Local) => Ok(real.access.get),
        _ => Err(unfit(variable, "only a Real that the model computes can be an unknown")),
    }
}

fn output<M>(variable: &'static Variable<M>, order: i32) -> Outcome<(Read<M>, Option<Read<M>>)> {
    check_order(variable, order)?;
    match (&variable.kind, variable.role) {
        (Kind::Real(real), Role::Output) => Ok((real.access.get, real.derivative)),
        _ => Err(unfit(variable, "only Real outputs have time derivatives")),
    }
}

fn input_slope<M>(variable: &'static Variable<M>, order: i32) -> Outcome<Slope<M>> {
    check_order(variable, order)?;
    let slope = match &variable.kind {
        Kind::Real(real) => real.slope,
        _ => None,
    };
    let why = "only inputs that may vary within a step take time derivatives";
    slope.ok_or_else(|| unfit(variable, why))
}

fn check_order<M>(variable: &Variable<M>, order: i32) -> Outcome {
    if order == 1 {
        return Ok(());
    }
    Err(unfit(variable, format!("the order of a time derivative must be 1, not {order}")))
}

fn unfit<M>(variable: &Variable<M>, why: impl Into<String>) -> Refusal {
    Refusal::Derivative { name: variable.name, why: why.into() }
}

#[cfg(test)]
mod tests {
    use std::ptr::null_mut;

    use serde::{Deserialize, Serialize};

    use super::*;
    use crate::boundary::logger::Logger;
    use crate::boundary::types::Status;
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

        fn initialise(&mut self, _: &Experiment, _: &mut dyn Log) -> Result<(), Fault> {
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
    fn rates_that_cannot_be_computed_are_discarded() -> Outcome {
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
    fn rates_are_computed_once_until_something_changes() -> Outcome {
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
