"use strict";
// Simulates points with an FMU's WebAssembly module: the functions of FMI 2.0 for Co-Simulation ; `task` is what `page.js`
// writes.
const Simulator = (module, task) => {
  const PAGE = 65536, OK = 1, DISCARD = 2, ERROR = 3, TERMINATED = 3;
  const NAME = 0, GUID = 256, CALLBACKS = 2048, REFERENCE = 2080, NUMBER = 2088, ORDER = 2096;
  const ramps = task.cases.some(({ inputs }) => inputs.some(({ ramp }) => ramp));
  const NEEDED = ["Instantiate", "FreeInstance", "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode", "DoStep", "Terminate",
    ...(ramps ? ["SetRealInputDerivatives"] : [])].map(name => `fmi2${name}`);
  let fmi, own;
  // The instance of the last point, and whether such a one may be reset for the next: not known before one was compared with a new one.
  let used = 0, reuse;
  // The instance of the point at hand.
  let present = 0;

  const begin = () => {
    used = present = 0;
    fmi = new WebAssembly.Instance(module, {}).exports;
    const missing = NEEDED.find(name => typeof fmi[name] !== "function");
    if (missing || !fmi.memory) throw new Error(`the module does not export ${missing ?? "its memory"}`);
    fmi._initialize?.();
    // A page of our own: the module's allocator does not know of it.
    own = fmi.memory.grow(1) * PAGE;
    const put = (at, text) => new Uint8Array(fmi.memory.buffer, own + at, 255).set(new TextEncoder().encode(text).slice(0, 254));
    put(NAME, "point");
    put(GUID, task.guid);
  };
  const memory = () => new DataView(fmi.memory.buffer, own);
  const call = (name, ...values) => {
    const status = fmi[`fmi2${name}`](...values);
    if (status > OK) throw Object.assign(new Error(`fmi2${name} returned ${status}`), { status });
  };

  // Whole numbers round half away from zero, as the program does.
  const whole = v => Math.sign(v) * Math.floor(Math.abs(v) + 0.5);
  const set = (component, reference, content, value) => {
    memory().setUint32(REFERENCE, reference, true);
    if (content === "Real") memory().setFloat64(NUMBER, value, true);
    else memory().setInt32(NUMBER, content === "Boolean" ? Number(value >= 0.5) : whole(value), true);
    call(`Set${content}`, component, own + REFERENCE, 1, own + NUMBER);
  };
  const setSlope = (component, reference, slope) => {
    memory().setUint32(REFERENCE, reference, true);
    memory().setFloat64(NUMBER, slope, true);
    memory().setInt32(ORDER, 1, true);
    call("SetRealInputDerivatives", component, own + REFERENCE, 1, own + ORDER, own + NUMBER);
  };
  const get = (component, { reference, content }) => {
    memory().setUint32(REFERENCE, reference, true);
    // A module that writes nothing has no result, rather than the number before.
    if (content === "Real") memory().setFloat64(NUMBER, NaN, true);
    call(`Get${content}`, component, own + REFERENCE, 1, own + NUMBER);
    return content === "Real" ? memory().getFloat64(NUMBER, true) : memory().getInt32(NUMBER, true);
  };

  const timeIn = ({ start, stop, step, steps, leap, even }) => k => k >= steps ? stop : k < leap ? start : even + (k - leap) * step;

  // ---- inputs over time (`task/inputs.rs`) ---------------------------------------------------------------------------
  // How many of growing times come before the first that does not hold.
  const before = (times, holds) => {
    let [low, high] = [0, times.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (holds(times[middle])) low = middle + 1; else high = middle;
    }
    return low;
  };
  const between = ({ times, values, hold }, after, t) => {
    if (after === 0) return values[0] ?? 0;
    if (hold || after === times.length) return values[after - 1];
    const share = (t - times[after - 1]) / (times[after] - times[after - 1]);
    return values[after - 1] + share * (values[after] - values[after - 1]);
  };
  const inputAt = (input, t) => between(input, before(input.times, other => other <= t), t);
  const inputSlope = (input, t, next) => (between(input, before(input.times, other => other < next), next) - inputAt(input, t)) / (next - t);
  const feed = ({ inputs }, component, t) => { for (const input of inputs) set(component, input.slot.handle.reference, input.slot.handle.content, inputAt(input, t)); };

  const allowed = (slot, value) => {
    const stored = slot.handle.content === "Integer" ? whole(value) : value;
    return Number.isFinite(value) && !(stored < slot.min && slot.min !== null) && !(stored > slot.max && slot.max !== null)
      && (!slot.items.length || slot.items.includes(stored));
  };

  // ---- what is collected ---------------------------------------------------------------------------------------------
  const statistic = kind => {
    let last = 0, twice = 0, least = Infinity, most = -Infinity;
    const root = kind === "rms";
    return {
      add: (_, elapsed, v) => {
        const value = root ? v * v : v;
        twice += elapsed * (last + value);
        last = value;
        if (!(value >= least)) least = value;
        if (!(value <= most)) most = value;
      },
      result: span => {
        const mean = span > 0 ? 0.5 * twice / span : last;
        return { mean, rms: Math.sqrt(mean), min: least, max: most, amplitude: 0.5 * (most - least), final: last }[kind];
      },
    };
  };
  // A signal's values at given times, with straight lines between its own (`curves::Sampler`); null where it ends before.
  const sampler = times => {
    const SLACK = 1e-9, values = [];
    let last = [NaN, NaN];
    const next = () => times[values.length] ?? Infinity, slack = t => SLACK * Math.max(Math.abs(next()), Math.abs(t));
    return {
      add: (t, value) => {
        const [earlier, old] = last;
        while (next() <= t) {
          values.push(next() === t ? value
            : Number.isNaN(earlier) ? next() + slack(t) < t ? NaN : value
            : old + (next() - earlier) / (t - earlier) * (value - old));
        }
        last = [t, value];
      },
      finish: () => {
        const [t, value] = last;
        while (next() < Infinity) {
          if (Number.isNaN(t) || next() > t + slack(t)) return null;
          values.push(value);
        }
        return values;
      },
    };
  };
  // The metrics of `curves`.
  const sum = list => list.reduce((a, b) => a + b, 0);
  const METRICS = {
    "rmse": (model, { values }) => Math.sqrt(sum(model.map((v, i) => (v - values[i]) * (v - values[i]))) / values.length),
    "nrmse": (model, curve) => METRICS.rmse(model, curve) / curve.normaliser,
    "max-error": (model, { values }) => model.reduce((most, v, i) => Math.max(most, Math.abs(v - values[i])), 0),
    "corridor": (model, { values, band }) => model.filter((v, i) => Math.abs(v - values[i]) <= band[i]).length / values.length,
    "area": (model, { values }) => {
      const [a, b] = [model, values].map(list => Float64Array.from(list).sort());
      return sum(Array.from(a, (v, i) => Math.abs(v - b[i]))) / values.length;
    },
  };
  const collector = ({ statistic: kind, curve, at, signal: [factor, offset] }) => {
    if (!curve && at === null) return statistic(kind);
    const samples = sampler(curve ? curve.times : [at]);
    return {
      add: (t, _, v) => samples.add(t, v),
      result: () => {
        const found = samples.finish();
        if (!found || !curve) return found ? found[0] : NaN;
        const model = found.map(v => factor * v + offset);
        return model.length && model.every(Number.isFinite) ? METRICS[curve.metric](model, curve) : NaN;
      },
    };
  };

  // ---- a simulation --------------------------------------------------------------------------------------------------
  const created = () => {
    const component = fmi.fmi2Instantiate(own + NAME, 1, own + GUID, 0, own + CALLBACKS, 0, 0);
    if (!component) throw Object.assign(new Error("fmi2Instantiate refused"), { status: ERROR });
    return present = component;
  };
  const again = () => {
    const component = present = used;
    used = 0;
    call("Reset", component);
    return component;
  };
  const prepared = (scene, values, component) => {
    const { tolerance, times: { start, stop } } = scene;
    call("SetupExperiment", component, tolerance === null ? 0 : 1, tolerance ?? 0, start, 1, stop);
    for (const [reference, content, value] of scene.fixed) set(component, reference, content, value);
    task.varied.forEach((slot, k) => set(component, slot.handle.reference, slot.handle.content, values[k]));
    feed(scene, component, start);
    call("EnterInitializationMode", component);
    call("ExitInitializationMode", component);
    return component;
  };
  const once = (component, t, next) => {
    try {
      call("DoStep", component, t, next - t, 1);
    } catch (error) {
      if (error.status === DISCARD && fmi.fmi2GetBooleanStatus(component, TERMINATED, own + NUMBER) <= OK && memory().getInt32(NUMBER, true)) {
        throw Object.assign(new Error("the FMU ended a simulation by itself, which the page does not follow"), { whole: true });
      }
      throw error;
    }
  };
  // From one communication point to the next, with a step to each time at which a recorded input turns.
  const stepped = (scene, component, begin, end) => {
    const { stops, inputs } = scene;
    let t = begin;
    for (let k = before(stops, stop => stop <= begin); t < end; k++) {
      const next = k < stops.length && stops[k] < end ? stops[k] : end;
      feed(scene, component, t);
      for (const input of inputs) if (input.ramp) setSlope(component, input.slot.handle.reference, inputSlope(input, t, next));
      once(component, t, next);
      t = next;
    }
  };
  const done = component => {
    const ended = fmi.fmi2Terminate(component) <= OK;
    if (used || reuse === false || !ended || !fmi.fmi2Reset) fmi.fmi2FreeInstance(component);
    else used = component;
    present = 0;
  };
  // An error ends its instance. A trap leaves the module in no known state: it is made anew, which a browser does some hundred
  // times and then refuses. That ends the worker, not the points.
  const recovered = error => {
    try {
      if (!(error.status <= ERROR)) return begin();
      if (present) fmi.fmi2FreeInstance(present);
      present = 0;
    } catch (after) {
      throw Object.assign(after, { lost: true });
    }
  };
  const guarded = (scene, compute) => {
    try {
      return compute((values, ready = created) => prepared(scene, values, ready()));
    } catch (error) {
      if (error.whole) throw error;
      recovered(error);
      return null;
    }
  };

  const inUnits = ({ unit: [factor, offset] }, v) => factor * v + offset;
  const simulated = (scene, values, ready) => guarded(scene, instance => {
    const { times: { steps }, observed } = scene, time = timeIn(scene.times);
    const component = instance(values, ready), atEnd = ({ statistic, curve, at, seen: [from] }) => statistic === "final" && !curve && at === null && from === steps;
    const watched = observed.map(o => atEnd(o) ? null : { o, found: collector(o) });
    const watch = k => watched.forEach(own => {
      if (own && k >= own.o.seen[0] && k <= own.o.seen[1]) own.found.add(time(k), k > own.o.seen[0] ? time(k) - time(k - 1) : 0, get(component, own.o));
    });
    watch(0);
    for (let k = 1; k <= steps; k++) {
      stepped(scene, component, time(k - 1), time(k));
      watch(k);
    }
    const found = observed.map((o, k) => {
      if (!watched[k]) return get(component, o);
      const [from, to] = o.seen;
      return from > to ? NaN : watched[k].found.result(time(to) - time(from));
    });
    done(component);
    return found;
  });
  const caseOf = (scene, values) => {
    const compared = used !== 0 && reuse === undefined, none = scene.observed.map(() => NaN);
    let results = simulated(scene, values, reuse !== false && used ? again : created);
    if (compared) {
      // As the program does: the first point on a used instance runs on a new one, too, whose results count.
      const reused = results;
      results = simulated(scene, values, created);
      reuse = Boolean(reused && results && reused.every((v, k) => Object.is(v, results[k])));
    }
    if (!results || !results.every(Number.isFinite)) return none;
    return results.map((v, k) => scene.observed[k].curve ? v : inUnits(scene.observed[k], v));
  };

  /** A point's results in the study's units, case after case; NaN where it has none. `values` are in the study's units, too. */
  const point = values => {
    const own = task.varied.map((slot, k) => inUnits(slot, values[k])), fits = task.varied.every((slot, k) => allowed(slot, own[k]));
    return task.cases.flatMap(scene => fits ? caseOf(scene, own) : scene.observed.map(() => NaN));
  };

  /** The signals of a case at its communication points: { times, values } with a list a criterion; null where it fails. Where these
      are fewer than `few`, each step is cut into so many that there are about `few` instants. */
  const trace = (values, number, few) => {
    const scene = task.cases[number], { steps } = scene.times, at = timeIn(scene.times), parts = steps < few ? Math.ceil(few / steps) : 1;
    return guarded(scene, instance => {
      const component = instance(task.varied.map((slot, k) => inUnits(slot, values[k]))), times = [], lists = scene.observed.map(() => []);
      const note = t => {
        times.push(t);
        scene.observed.forEach((o, j) => lists[j].push(o.signal[0] * get(component, o) + o.signal[1]));
      };
      note(at(0));
      for (let k = 0; k < steps * parts; k++) {
        const step = Math.floor(k / parts), part = k % parts, [from, to] = [at(step), at(step + 1)];
        const place = part => part === parts ? to : from + part / parts * (to - from);
        stepped(scene, component, place(part), place(part + 1));
        note(place(part + 1));
      }
      done(component);
      return { times, values: lists };
    });
  };

  begin();
  return { point, trace };
};
