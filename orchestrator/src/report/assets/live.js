"use strict";
// Fresh points: drawn from the changed distributions, simulated by two workers with the FMU's own module. Before it is believed,
// it must give what the study has of some of its own points.
const Live = (() => {
  const POINTS = 2000, WORKERS = 2;
  /** A picture over time has at least about so many instants. */
  const FEW = 100;
  /** Seconds for a simulation, and how many may take longer. */
  const PATIENCE = 10, STUCK = 3;
  let task, workers = null, compared = null;

  // ---- the workers ----------------------------------------------------------------------------------------------
  const answer = () => {
    let simulator;
    onmessage = ({ data: { module, task: given, rows, traced } }) => {
      try {
        if (module) simulator = Simulator(module, given);
        else if (traced) postMessage({ result: simulator.trace(...traced) });
        else for (const row of rows) postMessage({ result: simulator.point(row) });
      } catch (error) {
        postMessage({ error: String(error.message ?? error), lost: error.lost });
        close();
      }
    };
  };
  // A worker does its jobs in turn. One that says nothing for too long, or has lost its module, is replaced: the job at hand is
  // given back with the answers until then, and the others are asked again.
  const employed = (module, own, address) => {
    const jobs = [];
    let worker = null, clock;
    const submit = job => {
      if (!worker) begin();
      jobs.push(job);
      worker.postMessage(job.message);
      if (jobs.length === 1) watch();
    };
    const dismiss = (message, { lost, stuck }) => {
      clearTimeout(clock);
      worker.terminate();
      worker = null;
      const [{ reject, answers }, ...others] = jobs.splice(0);
      reject(Object.assign(new Error(message), { lost, stuck, answers }));
      others.forEach(submit);
    };
    // Half of the time twice: a page that slept hears first what came meanwhile.
    const watch = (again = false) => {
      clearTimeout(clock);
      if (jobs.length) clock = setTimeout(() => again ? dismiss(`the module does not end a simulation within ${PATIENCE} s`, { lost: true, stuck: true }) : watch(true), 500 * PATIENCE);
    };
    const begin = () => {
      const own_ = worker = new Worker(address);
      worker.onmessage = ({ data: { result, error, lost } }) => {
        // What a dismissed worker still says is not heard.
        if (own_ !== worker) return;
        if (error) return void dismiss(error, { lost });
        const { answers, count, resolve } = jobs[0];
        answers.push(result);
        if (answers.length === count) {
          jobs.shift();
          resolve(answers);
        }
        watch();
      };
      worker.postMessage({ module, task: own });
    };
    return (message, count) => new Promise((resolve, reject) => submit({ message, count, answers: [], resolve, reject }));
  };
  const begin = async () => {
    const module = await WebAssembly.compile(await Packed.opened(task.module));
    const code = new Blob([`"use strict";const Simulator=${Simulator};(${answer})()`], { type: "text/javascript" });
    const address = URL.createObjectURL(code), { module: _, own: __, ...own } = task;
    return Array.from({ length: WORKERS }, () => employed(module, own, address));
  };
  const crew = () => workers ??= begin();
  // A point that the module does not survive, or does not end, fails; the others go on. A module that sticks again and again is
  // not asked any more.
  const simulated = async (ask, rows) => {
    const found = [];
    for (let stuck = 0; found.length < rows.length;) {
      try {
        found.push(...await ask({ rows: rows.slice(found.length) }, rows.length - found.length));
      } catch (error) {
        if (error.stuck) stuck += 1;
        if (stuck === STUCK) (workers = Promise.reject(error)).catch(() => {});
        if (!error.lost || stuck === STUCK) throw error;
        found.push(...error.answers, Array(task.cases.reduce((sum, { observed }) => sum + observed.length, 0)).fill(NaN));
      }
    }
    return found;
  };
  /** The results of rows of parameters. */
  const results = async rows => {
    const hands = await crew(), part = Math.ceil(rows.length / hands.length);
    const parts = await Promise.all(hands.map((ask, k) => simulated(ask, rows.slice(k * part, (k + 1) * part))));
    const found = parts.flat();
    if (!found.some(own => own.every(Number.isFinite))) throw new Error("each of them failed in the module");
    return found;
  };

  // ---- points of the study ------------------------------------------------------------------------------------------
  // A module that computes something else than the study did is not asked again.
  const compare = async columns => {
    const found = await results(task.own.map(({ values }) => values));
    task.own.forEach(({ id, results: own, within }, i) => own.forEach((value, k) => {
      if (Math.abs(found[i][k] - value) <= within[k]) return;
      const short = v => String(Number(v.toPrecision(8))), said = Number.isFinite(found[i][k]) ? `is ${short(found[i][k])}` : "has no value";
      throw new Error(`the module does not give the study's own points: ${columns[k].name} of point ${id} ${said} instead of ${short(value)}`);
    }));
  };

  // ---- fresh points -----------------------------------------------------------------------------------------------
  // Numbers evenly from 0 to 1, without the ends: the generator sfc32 (C. Doty-Humphrey, PractRand), 53 bits at a time.
  const generator = seed => {
    let a = 0x9E3779B9, b = 0x243F6A88, c = 0xB7E15162, count = seed | 0;
    const next = () => {
      const sum = (a + b + count) | 0;
      count = (count + 1) | 0;
      a = b ^ (b >>> 9);
      b = (c + (c << 3)) | 0;
      c = ((c << 21) | (c >>> 11)) + sum | 0;
      return sum >>> 0;
    };
    for (let k = 0; k < 20; k++) next();
    return () => ((next() >>> 5) * 2 ** 26 + (next() >>> 6) + 0.5) / 2 ** 53;
  };
  const normal = uniform => Math.sqrt(-2 * Math.log(uniform())) * Math.cos(2 * Math.PI * uniform());
  // A standard normal number between two limits that leave little of it: by the quantile, on the side where small tails are exact.
  const cut = ([low, high], uniform) => {
    if (low > 0) return -cut([-high, -low], uniform);
    const [least, most] = [low, high].map(Numbers.below), share = least + (most - least) * uniform();
    let [from, to] = [Math.max(low, -40), Math.min(high, 40)];
    for (let half = 0; half < 60; half++) {
      const middle = 0.5 * (from + to);
      if (Numbers.below(middle) < share) from = middle; else to = middle;
    }
    return to;
  };
  const drawn = (q, uniform) => {
    const { mean, deviation, min, mode, max } = q;
    switch (q.distribution) {
      case "normal": return mean + deviation * normal(uniform);
      case "truncated-normal":
        for (let trial = 0; trial < 20; trial++) {
          const value = mean + deviation * normal(uniform);
          if (value >= (min ?? -Infinity) && value <= (max ?? Infinity)) return value;
        }
        return mean + deviation * cut([min ?? -Infinity, max ?? Infinity].map(end => (end - mean) / deviation), uniform);
      case "lognormal": {
        const variance = Math.log(1 + (deviation / mean) ** 2);
        return Math.exp(Math.log(mean) - variance / 2 + Math.sqrt(variance) * normal(uniform));
      }
      case "uniform": return min + (max - min) * uniform();
      case "triangular": {
        const place = uniform(), cut = (mode - min) / (max - min);
        return place < cut ? min + Math.sqrt(place * (max - min) * (mode - min)) : max - Math.sqrt((1 - place) * (max - min) * (max - mode));
      }
      case "fixed": return q.value;
      default: throw new Error(`points of the distribution ${q.distribution} cannot be drawn in the page`);
    }
  };

  /** Points of the changed distributions with their results, as `Judge` takes them. */
  const points = async (parameters, changes, seed = 1) => {
    const uniform = generator(seed), own = parameters.map((q, k) => ({ ...q, ...changes[k] }));
    const rows = Array.from({ length: POINTS }, () => own.map(q => drawn(q, uniform)));
    await compared;
    const found = await results(rows);
    return {
      size: POINTS, samples: 1, grid: false,
      completed: Uint8Array.from(found, own => own.every(Number.isFinite) ? 1 : 0),
      values: found[0].map((_, k) => Float64Array.from(found, own => own[k])),
      parameters: own.map((_, k) => Float64Array.from(rows, row => row[k])),
    };
  };

  // The signals of the first criteria over time, with the measured curves: { times, values, curve }; a null where a case fails.
  const SHOWN = 4;
  const traces = async values => {
    const [ask] = await crew(), found = [];
    for (const [number, { observed }] of task.cases.entries()) {
      if (found.length >= SHOWN) break;
      const [own] = await ask({ traced: [values, number, FEW] }, 1);
      observed.forEach(({ curve }, k) => found.push(own && { times: own.times, values: own.values[k], curve }));
    }
    return found.slice(0, SHOWN);
  };

  /** Small pictures of a point over time, below each other. */
  const draw = async (values, columns, place, { make, number }) => {
    let found;
    try {
      found = await traces(values);
    } catch {
      found = [];
    }
    if (!place.isConnected) return;
    if (!found.some(Boolean)) return void (make("p", "cannot be simulated here", place).className = "quiet");
    const [WIDTH, HEIGHT, NS] = [220, 36, "http://www.w3.org/2000/svg"];
    found.forEach((own, k) => {
      const { name, unit } = columns[k];
      if (!own) return void (make("p", `${name}: fails`, place).className = "quiet");
      const { times, values: list, curve } = own, span = times.at(-1) - times[0], all = curve ? list.concat(curve.values) : list;
      const low = all.reduce((a, b) => Math.min(a, b)), high = all.reduce((a, b) => Math.max(a, b));
      const line = (at, of) => `M${of.map((v, i) => `${(WIDTH * (at[i] - times[0]) / span).toFixed(1)},${(HEIGHT - 2 - (HEIGHT - 4) * (high > low ? (v - low) / (high - low) : 0.5)).toFixed(1)}`).join("L")}`;
      const what = curve ? `${name}, the signal and what was measured` : name, ofUnit = !curve && unit && unit !== "1" ? ` ${unit}` : "";
      make("p", `${what}: ${number(low)} .. ${number(high)}${ofUnit} at ${times.length} instants of ${number(span)} s`, place).className = "quiet";
      const svg = document.createElementNS(NS, "svg");
      svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
      svg.setAttribute("class", "trace");
      for (const [kind, at, of] of [["measured", curve?.times, curve?.values], ["", times, list]]) {
        if (!at) continue;
        const path = document.createElementNS(NS, "path");
        path.setAttribute("class", kind);
        path.setAttribute("d", line(at, of));
        svg.append(path);
      }
      place.append(svg);
    });
  };

  const start = columns => {
    const place = document.getElementById("module");
    if (!place) return;
    task = JSON.parse(place.textContent);
    compared = compare(columns).catch(error => {
      task = null;
      throw error;
    });
    compared.catch(() => {});
  };
  const able = () => Boolean(task);
  /** Ends in an error where the module is not to be believed. */
  const checked = () => compared;
  return { POINTS, start, able, checked, drawn, points, draw };
})();
