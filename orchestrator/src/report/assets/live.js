"use strict";
// Fresh points: drawn from the changed distributions, simulated by two workers with the FMU's own module.
const Live = (() => {
  const POINTS = 2000, WORKERS = 2, STEPS = 200;
  let task, workers = null;

  // ---- the workers ----------------------------------------------------------------------------------------------
  const answer = () => {
    let simulator;
    onmessage = ({ data: { id, module, task: given, rows, values, steps } }) => {
      try {
        if (module) simulator = Simulator(module, given);
        else if (steps) postMessage({ id, result: simulator.trace(values, steps) });
        else postMessage({ id, result: Float64Array.from(rows.flatMap(row => simulator.point(row))) });
      } catch (error) {
        postMessage({ id, error: String(error.message ?? error) });
      }
    };
  };
  const waiting = new Map();
  const ask = (worker, message) => new Promise((resolve, reject) => {
    const id = waiting.size ? Math.max(...waiting.keys()) + 1 : 1;
    waiting.set(id, { resolve, reject });
    worker.postMessage({ id, ...message });
  });
  const unpacked = async text => {
    const bytes = Uint8Array.from(atob(text), c => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).arrayBuffer();
  };
  const begin = async () => {
    const module = await WebAssembly.compile(await unpacked(task.module));
    const code = new Blob([`"use strict";const Simulator=${Simulator};(${answer})()`], { type: "text/javascript" });
    const address = URL.createObjectURL(code), { module: _, ...own } = task;
    return Array.from({ length: WORKERS }, () => {
      const worker = new Worker(address);
      worker.onmessage = ({ data: { id, result, error } }) => {
        const { resolve, reject } = waiting.get(id) ?? {};
        waiting.delete(id);
        if (error) reject?.(new Error(error)); else resolve?.(result);
      };
      worker.postMessage({ module, task: own });
      return worker;
    });
  };
  const crew = () => workers ??= begin();

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
  const drawn = (q, uniform) => {
    const { mean, deviation, min, mode, max } = q;
    switch (q.distribution) {
      case "normal": return mean + deviation * normal(uniform);
      case "truncated-normal":
        for (;;) {
          const value = mean + deviation * normal(uniform);
          if (value >= (min ?? -Infinity) && value <= (max ?? Infinity)) return value;
        }
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
    const own_ = await crew(), part = Math.ceil(POINTS / own_.length);
    const parts = await Promise.all(own_.map((worker, k) => ask(worker, { rows: rows.slice(k * part, (k + 1) * part) })));
    const results = parts.flatMap(list => Array.from(list)), n = task.observed.length;
    return {
      size: POINTS, samples: 1, grid: false,
      completed: Uint8Array.from(rows, (_, i) => Number.isFinite(results[i * n]) ? 1 : 0),
      values: task.observed.map((_, k) => Float64Array.from(rows, (_, i) => results[i * n + k])),
      parameters: own.map((_, k) => Float64Array.from(rows, row => row[k])),
    };
  };

  /** A point's criteria over time: { times, values }, or null where it fails. */
  const trace = async values => ask((await crew())[0], { values, steps: STEPS });

  /** Small pictures of a point over time, below each other. */
  const draw = async (values, columns, place, { make, number }) => {
    let found;
    try {
      found = await trace(values);
    } catch {
      found = null;
    }
    if (!place.isConnected) return;
    if (!found) return void (make("p", "cannot be simulated here", place).className = "quiet");
    const [WIDTH, HEIGHT, NS] = [220, 36, "http://www.w3.org/2000/svg"], { times } = found, span = times.at(-1) - times[0];
    found.values.slice(0, 4).forEach((list, k) => {
      const low = list.reduce((a, b) => Math.min(a, b)), high = list.reduce((a, b) => Math.max(a, b));
      const line = list.map((v, i) => `${(WIDTH * (times[i] - times[0]) / span).toFixed(1)},${(HEIGHT - 2 - (HEIGHT - 4) * (high > low ? (v - low) / (high - low) : 0.5)).toFixed(1)}`);
      make("p", `${columns[k].name}: ${number(low)} – ${number(high)}${columns[k].unit && columns[k].unit !== "1" ? ` ${columns[k].unit}` : ""} at ${times.length} instants of ${number(span)} s`, place).className = "quiet";
      const svg = document.createElementNS(NS, "svg"), path = document.createElementNS(NS, "path");
      svg.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
      svg.setAttribute("class", "trace");
      path.setAttribute("d", `M${line.join("L")}`);
      svg.append(path);
      place.append(svg);
    });
  };

  const start = data => { task = data.live ?? null; };
  const able = () => Boolean(task);
  return { POINTS, start, able, points, trace, draw };
})();
