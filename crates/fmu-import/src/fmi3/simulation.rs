//! A component of FMI 3.0.
//!
//! One for Co-Simulation without event mode handles its events within its steps, and inputs may be set between any two of
//! them. With event mode a step may end early, and `exchange` handles the events.

use std::{collections::HashMap, ptr, sync::Arc};

use super::{
    element::Element,
    functions::{Functions, Instantiates, LogMessage},
};
use crate::{
    call::{Call, Called, EarlyEnd, Status},
    caller::Caller,
    component::{CommonFunctions, ComponentBase, c_string},
    description::Storage,
    logger::fmu_import_log,
    simulation::{Birth, Experiment, Simulation, Within},
    value::{Handle, Value},
};

const DO_STEP: &str = "fmi3DoStep";

/// The values of arrays, by the references of their variables.
type Written = HashMap<u32, Vec<Value>>;

/// A component for Co-Simulation; the equations of one for Model Exchange stand on it.
#[derive(Debug)]
pub struct Model {
    pub base: ComponentBase,
    pub functions: Arc<Functions>,
    pub elements: Arc<[Element]>,
    /// The values of the arrays that were written before the initialisation, by their references; none after it.
    pub written: Option<Written>,
    experiment: Experiment,
    /// Numbers of plain elements that were read together last, and their value references.
    together: Vec<u32>,
    references: Vec<u32>,
    /// The array that the last call read, with the number of that call, and the reference of its variable.
    pub array: Option<(u64, u32, Vec<Value>)>,
}

impl Model {
    /// Creates a component; `events` lets its caller handle the events of Co-Simulation.
    pub fn new(
        functions: Arc<Functions>,
        common: CommonFunctions,
        elements: Arc<[Element]>,
        birth: &Birth,
        events: bool,
        mut caller: Caller,
        name: &str,
    ) -> Called<Self> {
        const LOGGER: LogMessage = fmu_import_log;
        let [name, token, resources] = [name, &birth.guid, &birth.resources].map(c_string);
        let environment = caller.log.environment();
        let [name, token, resources] = [&name, &token, &resources].map(|text| text.as_ptr());
        let (function, component) = match functions.instantiate {
            Instantiates::CoSimulation(function) => {
                let create = function.get()?;
                // SAFETY: the strings live through the call; there are no intermediate variables, and no callback for
                // them.
                let component = caller.call(|| unsafe {
                    create(
                        name,
                        token,
                        resources,
                        false,
                        false,
                        events,
                        events,
                        ptr::null(),
                        0,
                        environment,
                        LOGGER,
                        ptr::null(),
                    )
                });
                (function.name, component)
            }
            Instantiates::ModelExchange(function) => {
                let create = function.get()?;
                // SAFETY: the strings live through the call.
                let component =
                    caller.call(|| unsafe { create(name, token, resources, false, false, environment, LOGGER) });
                (function.name, component)
            }
        };
        let base = birth.base(component, common, caller, function)?;
        Ok(Self {
            base,
            functions,
            elements,
            written: Some(Written::new()),
            experiment: Experiment::default(),
            together: Vec::new(),
            references: Vec::new(),
            array: None,
        })
    }

    /// Whether all are numbers by themselves, whose value references are in `references` then.
    fn are_plain(&mut self, numbers: &[u32]) -> bool {
        if self.together == numbers {
            return true;
        }
        let elements = &self.elements;
        let plain = |number: &u32| elements.get(*number as usize).filter(|one| one.is_plain());
        let references = numbers.iter().map(|number| plain(number).map(|element| element.reference));
        let Some(references) = references.collect::<Option<Vec<u32>>>() else { return false };
        self.references = references;
        self.together = numbers.to_vec();
        true
    }
}

impl Simulation for Model {
    fn part(&mut self, time: f64, step: f64) -> Called<(f64, bool)> {
        let (mut event, mut terminate, mut early) = (0_u8, 0_u8, 0_u8);
        let mut reached = f64::NAN;
        // SAFETY: the component is alive, and the four places are valid.
        let done = self.base.call(self.functions.do_step, |do_step, of| unsafe {
            do_step(of, time, step, true, &raw mut event, &raw mut terminate, &raw mut early, &raw mut reached)
        });
        let (ended, event) = (terminate != 0, event != 0);
        let known = (time..=time + step).contains(&reached);
        let end = |otherwise| Call {
            function: DO_STEP,
            status: Status::Discard,
            message: Some("the FMU wants no further step".to_owned()),
            ended: Some(EarlyEnd { from: time, at: if known { reached } else { otherwise } }),
        };
        match done {
            Err(call) if ended && call.status == Status::Discard => Err(end(time)),
            Err(call) => Err(call),
            Ok(()) if ended => Err(end(time + step)),
            Ok(()) if early == 0 || reached == time + step => Ok((time + step, event)),
            Ok(()) if known && (reached > time || event) => Ok((reached, event)),
            Ok(()) => {
                Err(Call::impossible(DO_STEP, format!("it returned early, at {reached} s of a step from {time} s")))
            }
        }
    }

    fn resize(&mut self, sizes: &[(u32, u64)]) -> Called {
        let access = self.functions.uint64;
        self.base.plain(self.functions.enter_configuration_mode)?;
        for (reference, size) in sizes {
            // SAFETY: the component is alive, and there is one value.
            self.base.call(access.set, |set, of| unsafe { set(of, &raw const *reference, 1, &raw const *size, 1) })?;
        }
        self.base.plain(self.functions.exit_configuration_mode)
    }

    fn hear(&mut self, categories: &[String]) {
        let function = self.functions.set_debug_logging;
        // SAFETY: the array holds as many valid strings as stated.
        self.base.hear(categories, function, |log, of, count, texts| unsafe { log(of, true, count, texts) });
    }

    fn base(&self) -> &ComponentBase {
        &self.base
    }

    fn base_mut(&mut self) -> &mut ComponentBase {
        &mut self.base
    }

    fn set_up(&mut self, experiment: Experiment) -> Called {
        // Told when the initialisation begins.
        self.experiment = experiment;
        Ok(())
    }

    fn initialise(&mut self, within: Within) -> Called {
        let Experiment { start, stop, tolerance } = self.experiment;
        let (known, tolerance) = (tolerance.is_some(), tolerance.unwrap_or(0.0));
        let function = self.functions.enter_initialization_mode;
        // SAFETY: the component is alive.
        self.base.call(function, |enter, of| unsafe { enter(of, known, tolerance, start, true, stop) })?;
        within(self)?;
        self.written = None;
        self.base.exit_initialization_mode()
    }

    #[inline(never)]
    fn reals(&mut self, references: &[u32], into: &mut [f64]) -> Called {
        assert_eq!(references.len(), into.len(), "a place for each reference");
        let access = self.functions.float64;
        if self.are_plain(references) {
            let (references, count) = (self.references.as_ptr(), into.len());
            let into = into.as_mut_ptr();
            // SAFETY: both arrays hold `count` elements.
            return self.base.call(access.get, |get, of| unsafe { get(of, references, count, into, count) });
        }
        // The elements of an array are read together.
        let mut array: Option<(u32, Vec<f64>)> = None;
        let elements = Arc::clone(&self.elements);
        for (number, place) in references.iter().zip(into) {
            let element = Element::of(&elements, *number)?;
            if element.of == 1 || element.storage != Storage::Float64 {
                *place = self.read(*number)?.number();
                continue;
            }
            let known = array.take().filter(|(of, _)| *of == element.reference);
            let (_, values) = array.insert(match known {
                Some(known) => known,
                None => (element.reference, self.all(access, element, 0.0)?),
            });
            *place = values[element.index];
        }
        Ok(())
    }

    fn value(&mut self, handle: Handle) -> Called<Value> {
        self.read(handle.reference)
    }

    fn set(&mut self, reference: u32, value: &Value) -> Called {
        self.write(reference, value)
    }

    fn set_slope(&mut self, _: u32, _: f64) -> Called {
        Err(Call::impossible("fmi3SetRealInputDerivatives", "FMI 3.0 has no function for rates of inputs".to_owned()))
    }

    #[inline(never)]
    fn step(&mut self, time: f64, step: f64) -> Called {
        let end = time + step;
        let (mut from, mut rest) = (time, step);
        loop {
            let (at, _) = self.part(from, rest)?;
            if at == from + rest {
                return Ok(());
            }
            // The rest of the step.
            (from, rest) = (at, end - at);
        }
    }

    fn reset(&mut self) -> Called {
        self.written = Some(Written::new());
        self.base.reset()
    }
}
