"use strict";
// Simulates points with an FMU's WebAssembly module: the functions of FMI 2.0 for Co-Simulation (docs/live.md). The function is
// whole by itself, since a worker gets its text. `task` is what `report/live.rs` writes.
const Simulator = (module, task) => {
  const PAGE = 65536, OK = 1, DISCARD = 2, ERROR = 3, TERMINATED = 3;
  const NAME = 0, GUID = 256, CALLBACKS = 2048, REFERENCE = 2080, NUMBER = 2088;
  const NEEDED = ["Instantiate", "FreeInstance", "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode", "DoStep", "Terminate"].map(name => `fmi2${name}`);
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
    else memory().setInt32(NUMBER, whole(value), true);
    call(`Set${content}`, component, own + REFERENCE, 1, own + NUMBER);
  };
  const get = (component, { reference, content }) => {
    memory().setUint32(REFERENCE, reference, true);
    // A module that writes nothing has no result, rather than the number before.
    if (content === "Real") memory().setFloat64(NUMBER, NaN, true);
    call(`Get${content}`, component, own + REFERENCE, 1, own + NUMBER);
    return content === "Real" ? memory().getFloat64(NUMBER, true) : memory().getInt32(NUMBER, true);
  };

  const { start, stop, step, steps, leap, even, from } = task.times;
  const time = k => k >= steps ? stop : k < leap ? start : even + (k - leap) * step;

  const allowed = (slot, value) => {
    const stored = slot.content === "Integer" ? whole(value) : value;
    return Number.isFinite(value) && !(stored < slot.min && slot.min !== null) && !(stored > slot.max && slot.max !== null)
      && (!slot.items.length || slot.items.includes(stored));
  };

  // What the program's statistics collect: `at` is a communication point, `elapsed` the time since the one before.
  const collector = ({ statistic }) => {
    let last = 0, twice = 0, squares = 0, least = Infinity, most = -Infinity;
    const root = statistic === "rms";
    return {
      add: (elapsed, v) => {
        const value = root ? v * v : v;
        twice += elapsed * (last + value);
        last = value;
        if (!(value >= least)) least = value;
        if (!(value <= most)) most = value;
      },
      result: span => {
        const mean = span > 0 ? 0.5 * twice / span : last;
        return { mean, rms: Math.sqrt(mean), min: least, max: most, amplitude: 0.5 * (most - least), final: last }[statistic];
      },
    };
  };

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
  const prepared = (values, component) => {
    call("SetupExperiment", component, task.tolerance === null ? 0 : 1, task.tolerance ?? 0, start, 1, stop);
    for (const [reference, content, value] of task.fixed) set(component, reference, content, value);
    task.varied.forEach((slot, k) => set(component, slot.reference, slot.content, values[k]));
    call("EnterInitializationMode", component);
    call("ExitInitializationMode", component);
    return component;
  };
  const stepped = (component, t, next) => {
    try {
      call("DoStep", component, t, next - t, 1);
    } catch (error) {
      if (error.status === DISCARD && fmi.fmi2GetBooleanStatus(component, TERMINATED, own + NUMBER) <= OK && memory().getInt32(NUMBER, true)) {
        throw Object.assign(new Error("the FMU ended a simulation by itself, which the page does not follow"), { whole: true });
      }
      throw error;
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
  const guarded = compute => {
    try {
      return compute((values, ready = created) => prepared(values, ready()));
    } catch (error) {
      if (error.whole) throw error;
      recovered(error);
      return null;
    }
  };

  /** A point's results in the study's units; NaN where it has none. `values` are in the study's units, too. */
  const point = values => {
    const own = task.varied.map(({ unit: [factor, offset] }, k) => factor * values[k] + offset);
    const none = task.observed.map(() => NaN), compared = used !== 0;
    if (!task.varied.every((slot, k) => allowed(slot, own[k]))) return none;
    const once = ready => guarded(instance => {
      const component = instance(own, ready), collectors = task.observed.map(collector);
      const watched = task.observed.map((o, k) => [o, collectors[k]]).filter(([o]) => o.statistic !== "final");
      const watch = elapsed => watched.forEach(([o, c]) => c.add(elapsed, get(component, o)));
      if (from === 0) watch(0);
      for (let k = 1; k <= steps; k++) {
        stepped(component, time(k - 1), time(k));
        if (k >= from) watch(k > from ? time(k) - time(k - 1) : 0);
      }
      const found = task.observed.map((o, k) => o.statistic === "final" ? get(component, o) : collectors[k].result(stop - time(from)));
      done(component);
      return found;
    });
    let results = reuse !== false && used ? once(again) : once(created);
    if (reuse === undefined && compared) {
      // As the program does: the first point on a used instance runs on a new one, too, whose results count.
      const before = results;
      results = once(created);
      reuse = Boolean(before && results && before.every((v, k) => Object.is(v, results[k])));
    }
    if (!results || !results.every(Number.isFinite)) return none;
    return results.map((v, k) => task.observed[k].unit[0] * v + task.observed[k].unit[1]);
  };

  /** A point over time, at so many even steps: { times, values } with a list a criterion; null where it fails. */
  const trace = (values, count) => guarded(instance => {
    const own = task.varied.map(({ unit: [factor, offset] }, k) => factor * values[k] + offset);
    const component = instance(own), times = [], lists = task.observed.map(() => []);
    const at = k => k === count ? stop : start + k * (stop - start) / count;
    for (let k = 0; k <= count; k++) {
      if (k > 0) stepped(component, at(k - 1), at(k));
      times.push(at(k));
      task.observed.forEach((o, j) => lists[j].push(o.unit[0] * get(component, o) + o.unit[1]));
    }
    done(component);
    return { times, values: lists };
  });

  begin();
  return { point, trace };
};
