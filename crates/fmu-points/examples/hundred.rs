//! A hundred points of any FMU in isolated processes: `hundred FMU PARAMETER [STEP]` varies a parameter by 10 % around its
//! start value, and prints the outputs at the end of each simulation.

use std::time::Duration;

use fmu_import::{Causality, Package};
use fmu_points::task::{Probe, Schedule, Slot, Statistic, Task};
use fmu_points::{Crew, Isolation, PointLimits, WorkerSite, stop};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The processes in which the FMU runs are this program once more.
    fmu_points::serve_if_worker();
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [path, name, step @ ..] = &arguments[..] else {
        return Err("usage: hundred FMU PARAMETER [STEP]".into());
    };
    let mut package = Package::open(path.as_ref())?;
    let fmu = package.description();
    let parameter = fmu.variables.get(name).ok_or("no such parameter")?;
    let start = parameter.kind.start().ok_or("no start value")?;
    let outputs = fmu.variables.values();
    let outputs = outputs.filter(|variable| variable.causality == Causality::Output);
    let mut schedule = Schedule::suggested(fmu);
    if let Some(step) = step.first() {
        schedule.step = step.parse()?;
    }
    let task = Task {
        varied: Slot::of(parameter).into_iter().collect(),
        observed: outputs.filter_map(|output| Probe::of(output, Statistic::Final)).collect(),
        ..Task::new(schedule)
    };
    let points: Vec<_> = (0..100).map(|k| vec![start * (0.9 + 0.002 * f64::from(k))]).collect();
    let (time, memory) = (Duration::from_secs(60), 2 << 30);
    let place = WorkerSite::Processes(PointLimits { time, memory }, Isolation::Fresh);
    let scratch = stop::scratch()?;
    let crew = Crew::new(&mut package, place, scratch.path(), 2)?;
    for (point, answer) in points.iter().zip(crew.answers(&task, &points)?) {
        match answer {
            Ok(values) => println!("{point:?}: {values:?}"),
            Err(failure) => println!("{point:?}: {failure}"),
        }
    }
    crew.conduct().remarks().iter().for_each(|remark| println!("{remark}"));
    Ok(())
}
