"use strict";
// The stand with its parameters as sliders. All pictures are of its results.
const Playground = (() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  // Name, words, unit, numbers from the unit to SI, ends of the slider.
  const CONTROLS = [
    ["drive.speed", "speed", "rpm", [Math.PI / 30, 0], 60, 1500],
    ["bearing.radialClearance", "radial clearance", "µm", [1e-6, 0], 10, 40],
    ["bearing.roughness", "roughness", "µm", [1e-6, 0], 0, 10],
    ["load.preload", "preload", "N", [1, 0], 20, 80],
    ["load.eccentricity", "load eccentricity", "mm", [1e-3, 0], 0, 0.8],
    ["oil.viscosityScale", "viscosity, times the oil's", "", [1, 0], 0.3, 2],
    ["thermal.ambientTemperature", "ambient temperature", "°C", [1, 273.15], 0, 40],
    ["thermal.initialOilTemperature", "oil at the start", "°C", [1, 273.15], 10, 100],
    ["thermal.initialBearingTemperature", "bearing at the start", "°C", [1, 273.15], 10, 120],
  ];
  const OVER_TIME = [["sensor.oilTemperature", [1, -273.15]], ["sensor.bearingTemperature", [1, -273.15]], ["sensor.frictionTorque", [1, 0]]];
  const TURN = [["bearing.eccentricityRatio", [1, 0]], ["bearing.attitudeAngle", [1, 0]], ["bearing.maxFilmPressure", [1e-6, 0]],
    ["sensor.frictionCoefficient", [1, 0]], ["sensor.loadForce", [1, 0]], ["bearing.contactShare", [1, 0]], ["bearing.filmViscosity", [1, 0]],
    ["bearing.hotRadialClearance", [1, 0]]];
  const SECONDS = 150, STEPS = 150, FINE = 180;
  const round = v => Number(v.toPrecision(4));
  const state = {};
  let module, film;

  const variable = ([name, unit]) => ({ reference: data.variables[name][0], content: "Real", statistic: "final", at: null, curve: null, signal: unit });
  const task = (stop, steps, observed) => ({
    guid: data.guid,
    cases: [{
      tolerance: null, fixed: [], stops: [], inputs: [], observed: observed.map(variable),
      times: { start: 0, stop, step: stop / steps, steps, leap: 0, even: 0 },
    }],
    varied: CONTROLS.map(([name, , , unit]) => ({ handle: { reference: data.variables[name][0], content: "Real" }, unit, min: null, max: null, items: [] })),
  });
  const run = (stop, steps, observed, values) => Simulator(module, task(stop, steps, observed)).trace(values, 0, 0);
  const values = changes => CONTROLS.map(([name]) => ({ ...state, ...changes })[name]);

  // ---- drawing ------------------------------------------------------------------------------------------------
  const NS = "http://www.w3.org/2000/svg";
  const draw = (parent, name, attributes, words) => {
    const node = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    if (words !== undefined) node.textContent = words;
    parent.append(node);
    return node;
  };
  const ends = lists => {
    const all = lists.flat(), low = Math.min(...all), high = Math.max(...all), room = Math.max(0.05 * (high - low), 0.005 * Math.abs(high)) || 1;
    return [low - room, high + room];
  };
  // Round numbers from the low to the high end; of a logarithmic axis 1, 2 and 5 times powers of ten.
  const ticks = (low, high, count) => {
    const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw)), step = [1, 2, 2.5, 5, 10].map(m => m * power).find(s => s >= raw * 0.999);
    return Array.from({ length: Math.floor(high / step + 1e-9) - Math.ceil(low / step - 1e-9) + 1 }, (_, k) => (Math.ceil(low / step - 1e-9) + k) * step);
  };
  const decades = (low, high) => {
    const all = [];
    for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) all.push(...[1, 2, 5].map(m => m * 10 ** power));
    return all.filter(v => v >= low * 0.999 && v <= high * 1.001);
  };
  // As many digits as tell neighbours apart.
  const decimals = step => [...Array(12).keys()].find(count => Math.abs(step - Number(step.toFixed(count))) < 1e-6 * step) ?? 12;
  const label = (v, step) => v.toFixed(decimals(step)).replace("-", "−");
  // Lines over a common axis, each with its words; `mark` is a point of the first one.
  const plot = (id, across_, lines, [across, along], mark, logarithmic) => {
    const scaled = logarithmic ? Math.log10 : v => v, x = across_.map(scaled);
    const svg = document.getElementById(id), [left, right, top, bottom] = [56, 410, 26, 222];
    svg.replaceChildren();
    const [x0, x1] = [Math.min(...x), Math.max(...x)], [y0, y1] = ends(lines.map(line => line.list));
    const at = (a, b) => [left + (right - left) * (a - x0) / (x1 - x0), bottom - (bottom - top) * (b - y0) / (y1 - y0)];
    draw(svg, "path", { class: "axis", d: `M${left},${top}V${bottom}H${right}` });
    const upward = ticks(y0, y1, 4), sideways = logarithmic ? decades(10 ** x0, 10 ** x1) : ticks(x0, x1, 5);
    for (const v of upward) {
      const [, y] = at(x0, v);
      draw(svg, "path", { class: "grid", d: `M${left},${y.toFixed(1)}H${right}` });
      draw(svg, "text", { x: left - 6, y: y + 4, "text-anchor": "end" }, label(v, upward[1] - upward[0]));
    }
    for (const v of sideways) {
      const [x] = at(scaled(v), y0);
      draw(svg, "path", { class: "grid", d: `M${x.toFixed(1)},${top}V${bottom}` });
      draw(svg, "text", { x, y: bottom + 16, "text-anchor": x > right - 12 ? "end" : "middle" }, logarithmic ? round(v) : label(v, sideways[1] - sideways[0]));
    }
    draw(svg, "text", { x: right, y: 252, "text-anchor": "end" }, across);
    draw(svg, "text", { x: 4, y: 14 }, along);
    lines.forEach(({ list, words }, k) => {
      draw(svg, "path", { class: ["one", "two"][k], d: `M${list.map((v, i) => at(x[i], v).map(c => c.toFixed(1)).join()).join("L")}` });
      if (words) draw(svg, "text", { x: right, y: at(0, list.at(-1))[1] - 6, "text-anchor": "end" }, words);
    });
    if (mark) draw(svg, "circle", { class: "now", r: 5, cx: at(scaled(mark[0]), mark[1])[0], cy: at(0, mark[1])[1] });
  };
  // The field of the Reynolds equation at one instant, unrolled: around the bush from left to right, along it from bottom to top.
  const [COLUMNS, ROWS] = [96, 12];
  const VIRIDIS = ["440154", "472d7b", "3b528b", "2c728e", "21918c", "28ae80", "5ec962", "addc30", "fde725"].map(c => [0, 2, 4].map(k => parseInt(c.slice(k, k + 2), 16)));
  const shade = share => {
    const place = Math.min(Math.max(share, 0), 1) * (VIRIDIS.length - 1), k = Math.min(Math.floor(place), VIRIDIS.length - 2);
    return VIRIDIS[k].map((c, j) => Math.round(c + (place - k) * (VIRIDIS[k + 1][j] - c)));
  };
  const field = ({ times, values: [ratios, angles, pressures, , loads, shares, viscosities, clearances] }) => {
    const k = pressures.reduce((best, p, i) => p > pressures[best] ? i : best, 0), canvas = document.getElementById("field");
    const [width, diameter, friction] = ["bearing.width", "bearing.diameter", "bearing.boundaryFriction"].map(name => data.variables[name][1]);
    const unit = [Math.cos(angles[k]), Math.sin(angles[k])], scale = 12 * viscosities[k] * (diameter / 2 / clearances[k]) ** 2;
    // The film carries what touching asperities, which push from the wall to the middle, and their friction leave.
    const touched = [unit[0] - friction * unit[1], unit[1] + friction * unit[0]];
    const load = [1 - shares[k] * touched[0], -shares[k] * touched[1]].map(part => part * loads[k] / (scale * diameter / 2 * width));
    const { film_pressure, memory } = film, roughness = 1e-6 * state["bearing.roughness"] / clearances[k];
    const at = film_pressure(ratios[k] * unit[0], ratios[k] * unit[1], ...load, width / diameter, roughness);
    if (!at) return null;
    const cells = Array.from(new Float64Array(memory.buffer, at, COLUMNS * ROWS), p => p * scale / 1e6), most = Math.max(...cells);
    const [W, H, LEFT, TOP, WIDE, HIGH] = [840, 460, 96, 16, 610, 360], small = new OffscreenCanvas(COLUMNS, 2 * ROWS), image = new ImageData(COLUMNS, 2 * ROWS);
    Object.assign(canvas, { width: W, height: H });
    for (let i = 0; i < COLUMNS; i++) {
      for (let row = 0; row < 2 * ROWS; row++) {
        const j = row < ROWS ? ROWS - 1 - row : row - ROWS;
        image.data.set([...shade(cells[i * ROWS + j] / most), 255], 4 * (row * COLUMNS + i));
      }
    }
    small.getContext("2d").putImageData(image, 0, 0);
    const pen = canvas.getContext("2d"), colour = getComputedStyle(canvas).getPropertyValue("--soft");
    pen.drawImage(small, LEFT, TOP, WIDE, HIGH);
    Object.assign(pen, { fillStyle: colour, strokeStyle: colour, font: "24px system-ui, sans-serif", textAlign: "center" });
    for (const angle of [-180, -90, 0, 90, 180]) pen.fillText(`${angle}°`.replace("-", "−"), LEFT + WIDE * (angle + 180) / 360, TOP + HIGH + 30);
    pen.fillText("angle from the load line, in the direction of rotation", LEFT + WIDE / 2, TOP + HIGH + 64);
    pen.textAlign = "right";
    [[0, `${round(500 * width)}`], [0.5, "0"], [1, `−${round(500 * width)}`]].forEach(([share, words]) => pen.fillText(words, LEFT - 10, TOP + 8 + HIGH * share));
    pen.fillText("mm", LEFT - 10, TOP + HIGH * 0.27);
    pen.textAlign = "left";
    for (let y = 0; y < HIGH; y++) {
      pen.fillStyle = `rgb(${shade(1 - y / HIGH)})`;
      pen.fillRect(LEFT + WIDE + 14, TOP + y, 18, 1.5);
    }
    pen.fillStyle = colour;
    [[0, round(Number(most.toPrecision(3)))], [1, 0]].forEach(([share, words]) => pen.fillText(words, LEFT + WIDE + 40, TOP + 12 + (HIGH - 4) * share));
    pen.fillText("MPa", LEFT + WIDE + 40, TOP + HIGH / 2);
    document.getElementById("field-note").textContent = `${round(1e3 * times[k])} ms into the turn, when it is largest; the bush is unrolled.`;
    return [most, pressures[k]];
  };
  const orbit = ([ratios, angles]) => {
    const svg = document.getElementById("orbit"), at = k => [150 + 130 * ratios[k] * Math.sin(angles[k]), 150 + 130 * ratios[k] * Math.cos(angles[k])];
    svg.replaceChildren();
    draw(svg, "circle", { class: "circle", cx: 150, cy: 150, r: 130 });
    draw(svg, "path", { class: "axis", d: "M145,150h10M150,145v10" });
    draw(svg, "path", { class: "one", d: `M${ratios.map((_, k) => at(k).map(c => c.toFixed(1)).join()).join("L")}` });
    draw(svg, "circle", { class: "now", r: 4, cx: at(0)[0], cy: at(0)[1] });
    // The same, drawn larger in a corner: most orbits are small.
    const places = ratios.map((_, k) => at(k)), [xs, ys] = [0, 1].map(k => places.map(place => place[k]));
    const [low, high] = [[xs, ys].map(list => Math.min(...list)), [xs, ys].map(list => Math.max(...list))];
    const zoom = Math.min(56 / Math.max(high[0] - low[0], high[1] - low[1], 1e-6), 1000);
    if (zoom > 2) {
      const near = places.map(place => place.map((v, k) => [34, 34][k] + zoom * (v - (low[k] + high[k]) / 2)));
      draw(svg, "path", { class: "one", d: `M${near.map(place => place.map(c => c.toFixed(1)).join()).join("L")}` });
      draw(svg, "text", { x: 4, y: 80 }, `× ${round(Math.round(zoom))}`);
    }
    document.getElementById("orbit-note").textContent = `Eccentricity ratio ${round(Math.min(...ratios))} to ${round(Math.max(...ratios))}. The angle is the attitude angle from the load, which points down.`;
  };

  // ---- what is simulated ---------------------------------------------------------------------------------------
  // A turn at given temperatures, after others that forget where the journal started.
  const BEFORE = 4;
  const turn = (changes, steps) => {
    const speed = (changes["drive.speed"] ?? state["drive.speed"]) / 60, found = run((BEFORE + 1) / speed, (BEFORE + 1) * steps, TURN, values(changes)), from = BEFORE * steps;
    return found && { times: found.times.slice(from).map(t => t - found.times[from]), values: found.values.map(list => list.slice(from)) };
  };
  const mean = list => list.reduce((a, b) => a + b, 0) / list.length;
  let last = null;
  const simulate = () => {
    const begun = performance.now(), over = run(SECONDS, STEPS, OVER_TIME, values({})), note = document.getElementById("state");
    if (!over) return void (note.textContent = "The stand cannot run with these parameters: it would stop with a message in a simulation tool.");
    const [oil, bearing, torque] = over.values;
    plot("temperature", over.times, [{ list: bearing, words: "bearing" }, { list: oil, words: "oil" }], ["s", "°C"]);
    // The journal starts in the middle, without friction in the contact: that instant would hide the rest.
    plot("torque", over.times.slice(1), [{ list: torque.slice(1) }], ["s", "N·m"]);
    const warm = { "thermal.initialOilTemperature": oil.at(-1), "thermal.initialBearingTemperature": bearing.at(-1) }, now = turn(warm, FINE);
    if (!now) return void (note.textContent = "The turn at the end cannot be computed with these parameters.");
    orbit(now.values);
    const pressure = field(now);
    plot("pressure", now.times.map(t => 1e3 * t), [{ list: now.values[2] }], ["ms", "MPa"]);
    const own = mean(now.values[3]), speed = state["drive.speed"];
    const speeds = Array.from({ length: 24 }, (_, k) => 30 * 50 ** (k / 23));
    const curve = speeds.map(v => [v, turn({ ...warm, "drive.speed": v }, 48)]).filter(([, found]) => found).map(([v, found]) => [v, mean(found.values[3])]);
    plot("stribeck", curve.map(([v]) => v), [{ list: curve.map(([, f]) => f) }], ["speed in rpm, logarithmic", "friction coefficient"], [speed, own], true);
    last = { pressure, oil: oil.at(-1), bearing: bearing.at(-1), torque: torque.at(-1), friction: own, curve };
    note.textContent = `${SECONDS} s and ${(BEFORE + 1) * (curve.length + 1)} turns simulated in ${Math.round(performance.now() - begun)} ms.`;
  };

  // ---- controls ---------------------------------------------------------------------------------------------------
  let waiting = 0;
  const changed = () => { clearTimeout(waiting); waiting = setTimeout(simulate, 60); };
  const controls = () => {
    const place = document.getElementById("controls"), shows = [];
    CONTROLS.forEach(([name, words, unit, [factor, offset], least, most]) => {
      const label = document.createElement("label"), value = document.createElement("output"), slider = document.createElement("input");
      const start = (data.variables[name][1] - offset) / factor;
      Object.assign(slider, { type: "range", min: least, max: most, step: (most - least) / 400, title: name });
      slider.dataset.name = name;
      label.append(words, value, slider);
      place.append(label);
      const show = v => { state[name] = v; value.textContent = `${round(v)} ${unit}`; };
      slider.addEventListener("input", () => { show(slider.valueAsNumber); changed(); });
      shows.push(() => { slider.value = start; show(start); });
    });
    const begin = () => shows.forEach(show => show());
    document.querySelector("form").addEventListener("reset", event => { event.preventDefault(); begin(); changed(); });
    begin();
  };
  const begin = async () => {
    const bytes = Uint8Array.from(atob(data.module), c => c.charCodeAt(0));
    module = await WebAssembly.compile(await new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer());
    film = (await WebAssembly.instantiate(module, {})).exports;
    film._initialize?.();
    controls();
    simulate();
  };
  begin().catch(error => { document.getElementById("state").textContent = `The module cannot run in this browser: ${error.message}`; });

  return { last: () => last };
})();
