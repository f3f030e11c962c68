//! Derivatives: of inputs over time as the host gives them, of outputs over time, and of unknowns
//! along a direction of knowns.

use super::instance::Instance;
use super::phase::Phase;
use super::refusal::{Outcome, Refusal};
use super::types::{Integer, Real, Status, ValueReference};
use super::values::{check_settable, inside, type_name, variable};
use crate::model::{Access, Kind, Model, Role, Variable};

/// Step of the central difference, in units of a variable's magnitude: the cube root of the
/// rounding unit balances truncation against rounding (Press et al., Numerical Recipes, 2007,
/// section 5.7).
const RELATIVE_STEP: f64 = 6.055e-6;

/// Step of the one-sided difference over time, in units of the suggested communication step.
const TIME_STEP: f64 = 1e-3;

/// One real variable that the host may set, as directional derivatives need it.
struct Known<M: 'static> {
    set: fn(&mut M, &f64),
    value: f64,
    direction: f64,
    magnitude: f64,
    min: Option<f64>,
    max: Option<f64>,
}

impl<M: Model> Instance<M> {
    /// `fmi2SetRealInputDerivatives`. The slopes hold for the next step.
    pub fn set_input_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[Integer],
        values: &[Real],
    ) -> Outcome {
        let wanted = references.iter().zip(orders).zip(values);
        for ((reference, order), value) in wanted {
            let slope = input_slope(variable::<M>(*reference)?, *order)?;
            if !value.is_finite() {
                return Err(unfit(slope.0, format!("its derivative cannot be {value}")));
            }
        }
        let model = self.run.seed.as_mut().unwrap_or(&mut self.run.model);
        for (reference, value) in references.iter().zip(values) {
            let (_, set) = input_slope(variable::<M>(*reference)?, 1)?;
            set(model, *value);
        }
        self.run.sloped |= !references.is_empty();
        Ok(Status::Ok)
    }

    /// After a step, inputs are constant again until the host says otherwise.
    pub fn clear_slopes(&mut self) {
        if !std::mem::take(&mut self.run.sloped) {
            return;
        }
        for variable in M::variables() {
            if let Kind::Real {
                slope: Some(set), ..
            } = variable.kind
            {
                set(&mut self.run.model, 0.0);
            }
        }
    }

    /// `fmi2GetRealOutputDerivatives`: from the model where it knows the derivative, else by a
    /// one-sided difference of second order on a copy that goes a little ahead.
    pub fn get_output_derivatives(
        &mut self,
        references: &[ValueReference],
        orders: &[Integer],
        values: &mut [Real],
    ) -> Outcome {
        self.refresh()?;
        let mut ahead = None;
        for ((reference, order), value) in references.iter().zip(orders).zip(values.iter_mut()) {
            let (read, derivative) = output(variable::<M>(*reference)?, *order)?;
            *value = match derivative {
                Some(derivative) => derivative(&self.run.model),
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

    /// Copies of the model one and two short steps ahead.
    fn go_ahead(&self) -> Outcome<[M; 2]> {
        let (time, step) = (self.run.time, TIME_STEP * M::INFO.default_step);
        let mut near = self.run.model.clone();
        near.advance(time, step, &mut ())?;
        let mut far = near.clone();
        far.advance(time + step, step, &mut ())?;
        Ok([near, far])
    }

    /// `fmi2GetDirectionalDerivative`: the central difference along the direction, on copies of
    /// the model; one-sided, of second order, where a bound is near.
    pub fn get_directional_derivative(
        &mut self,
        unknowns: &[ValueReference],
        knowns: &[ValueReference],
        direction: &[Real],
        values: &mut [Real],
    ) -> Outcome {
        self.refresh()?;
        let reads = unknowns
            .iter()
            .map(|unknown| read(variable::<M>(*unknown)?))
            .collect::<Outcome<Vec<_>>>()?;
        let knowns = knowns
            .iter()
            .zip(direction)
            .map(|(known, direction)| self.known(variable::<M>(*known)?, *direction))
            .collect::<Outcome<Vec<_>>>()?;
        let rate = knowns.iter().fold(0.0_f64, |rate, known| {
            rate.max((known.direction / known.magnitude).abs())
        });
        if rate == 0.0 {
            values.fill(0.0);
            return Ok(Status::Ok);
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

    fn known(&self, variable: &'static Variable<M>, direction: f64) -> Outcome<Known<M>> {
        // What may be set decides what may be varied; after the end, as at the last point.
        let phase = match self.run.phase {
            Phase::Initialization => Phase::Initialization,
            _ => Phase::StepComplete,
        };
        check_settable(variable, phase)?;
        let Kind::Real {
            access: Access {
                get,
                set: Some(set),
            },
            min,
            max,
            nominal,
            ..
        } = &variable.kind
        else {
            return Err(unfit(
                variable,
                format!(
                    "a known is a Real that can be set, not {}",
                    type_name(variable)
                ),
            ));
        };
        if !direction.is_finite() {
            return Err(unfit(
                variable,
                format!("its direction cannot be {direction}"),
            ));
        }
        let value = get(self.run.seed.as_ref().unwrap_or(&self.run.model));
        let magnitude = match (value.abs(), nominal) {
            (value, Some(nominal)) => value.max(nominal.abs()),
            (0.0, None) => 1.0,
            (value, None) => value,
        };
        Ok(Known {
            set: *set,
            value,
            direction,
            magnitude,
            min: *min,
            max: *max,
        })
    }
}

/// Derivatives that overflow, as along directions of 1e300, are none.
fn bounded(values: &[Real]) -> Outcome {
    if values.iter().all(|value| value.is_finite()) {
        return Ok(Status::Ok);
    }
    Err(Refusal::Unsupported("a derivative is beyond all numbers"))
}

impl<M> Known<M> {
    fn at(&self, distance: f64) -> f64 {
        self.value + distance * self.direction
    }
}

/// Offsets in steps with their weights: central where all knowns stay within their bounds, else
/// ahead or back.
fn stencil<M>(knowns: &[Known<M>], step: f64) -> &'static [(f64, f64)] {
    let fits = |offset: f64| {
        knowns
            .iter()
            .all(|known| inside(known.at(offset * step), known.min, known.max))
    };
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
        (Kind::Real { access, .. }, Role::Output | Role::Local) => Ok(access.get),
        _ => Err(unfit(
            variable,
            "an unknown is a Real that the model computes".to_owned(),
        )),
    }
}

fn output<M>(
    variable: &'static Variable<M>,
    order: Integer,
) -> Outcome<(Read<M>, Option<Read<M>>)> {
    check_order(variable, order)?;
    match (&variable.kind, variable.role) {
        (
            Kind::Real {
                access, derivative, ..
            },
            Role::Output,
        ) => Ok((access.get, *derivative)),
        _ => Err(unfit(
            variable,
            "only Real outputs have derivatives".to_owned(),
        )),
    }
}

fn input_slope<M>(
    variable: &'static Variable<M>,
    order: Integer,
) -> Outcome<(&'static Variable<M>, Slope<M>)> {
    check_order(variable, order)?;
    match &variable.kind {
        Kind::Real {
            slope: Some(slope), ..
        } => Ok((variable, *slope)),
        _ => Err(unfit(
            variable,
            "only continuous inputs take derivatives".to_owned(),
        )),
    }
}

fn check_order<M>(variable: &Variable<M>, order: Integer) -> Outcome<()> {
    if order == 1 {
        return Ok(());
    }
    Err(unfit(
        variable,
        format!("derivatives are of order 1, not {order}"),
    ))
}

fn unfit<M>(variable: &Variable<M>, why: String) -> Refusal {
    Refusal::Derivative {
        name: variable.name,
        why,
    }
}
