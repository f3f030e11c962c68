"use strict";
// The page works without this script; with it, points can be hovered, selected and compared.
(async () => {
  // ---- data -------------------------------------------------------------------------------
  const data = JSON.parse(document.getElementById("data").textContent), held = Packed.held(document.getElementById("bytes"));
  const all = held instanceof Promise ? await held : held;
  const bytes = ([begin, end]) => all.subarray(begin, end), numbers = (part, Type) => Packed.numbers(bytes(part), Type);
  const ids = numbers(data.ids, Uint32Array);
  // Under a guard band fewer points are accepted than lie within all tolerances; these count as verified here.
  let verified = bytes(data.verified);
  const { word } = document.querySelector("main").dataset;
  const completed = bytes(data.completed);
  const columns = data.columns.map(c => ({
    ...c,
    data: numbers(c.data, c.criterion ? Float64Array : Float32Array),
    ok: c.criterion ? bytes(c.criterion.ok) : null,
    title: c.unit && c.unit !== "1" ? `${c.name} (${c.unit})` : c.name,
  }));
  const size = ids.length;
  const indexOf = new Map(Array.from(ids, (id, i) => [id, i]));
  const crowd = data.sampled;

  // ---- small tools ------------------------------------------------------------------------
  const SVG = "http://www.w3.org/2000/svg";
  const draw = (parent, name, attributes = {}, text) => {
    const node = document.createElementNS(SVG, name);
    for (const key in attributes) node.setAttribute(key, attributes[key]);
    if (text !== undefined) node.textContent = text;
    parent.append(node);
    return node;
  };
  const make = (name, text, parent) => {
    const node = document.createElement(name);
    if (text !== undefined) node.textContent = text;
    if (parent) parent.append(node);
    return node;
  };
  const parts = name => { const dot = name.lastIndexOf("."); return [name.slice(0, Math.max(dot, 0)), name.slice(dot + 1)]; };
  const heading = (c, th) => {
    const [path, name] = parts(c.name);
    th.scope = "col";
    th.className = "num";
    if (path) make("small", path, th);
    th.append(name);
    make("small", c.unit, th);
  };
  const number = (v, digits = 5) => {
    if (!Number.isFinite(v)) return "–";
    if (v === 0) return "0";
    const short = Number(v.toPrecision(digits));
    const size = Math.abs(short);
    return (size >= 1e-4 && size < 1e7 ? String(short) : short.toExponential()).replace(/-/g, "−");
  };
  const ticks = (low, high, count) => {
    const raw = (high - low) / Math.max(count, 1);
    if (!(raw > 0)) return [low];
    const power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 2.5, 5, 10].map(m => m * power).find(s => s >= raw * 0.999) ?? 10 * power;
    const out = [];
    for (let k = Math.ceil(low / step - 1e-9); k <= Math.floor(high / step + 1e-9); k++) out.push(k * step);
    return out;
  };
  const scale = ([low, high], from, to) => {
    const at = v => from + (v - low) / (high - low) * (to - from);
    return {
      low, high, from, to, at,
      has: v => v >= low && v <= high,
      clamp: v => at(Math.min(Math.max(v, low), high)),
      value: p => low + (p - from) / (to - from) * (high - low),
    };
  };
  const tolerance = c => [c.criterion?.lower ?? -Infinity, c.criterion?.upper ?? Infinity];
  // Of a criterion under a guard band it may be nothing.
  const drawnIn = range => range && [range[0] ?? -Infinity, range[1] ?? Infinity];
  const acceptedRange = c => data.guarded && c.criterion ? drawnIn(c.criterion.drawn_in) : tolerance(c);
  // A limit that stands alone has no measured value to be drawn.
  const isMeasured = c => c.criterion && Number.isFinite(c.criterion.lower ?? NaN) && Number.isFinite(c.criterion.upper ?? NaN);
  const inside = (c, i) => !c.ok || c.ok[i] === 1;
  const deviation = (c, i) => {
    const v = c.data[i], { nominal, lower, upper } = c.criterion;
    const room = v >= nominal ? (upper ?? Infinity) - nominal : nominal - (lower ?? -Infinity);
    return Math.abs(v - nominal) / room;
  };
  const local = (svg, event) => {
    const box = svg.getBoundingClientRect(), view = svg.viewBox.baseVal;
    return [(event.clientX - box.left) * view.width / box.width, (event.clientY - box.top) * view.height / box.height];
  };

  // ---- what is hovered and selected, and who wants to know ----------------------------------
  const state = { hover: -1, selected: new Set() };
  const watchers = [];
  let pending = false;
  const changed = () => {
    if (pending) return;
    pending = true;
    requestAnimationFrame(() => { pending = false; watchers.forEach(w => w()); });
  };
  const hover = i => { if (state.hover !== i) { state.hover = i; changed(); } };
  const select = (points, add) => {
    if (!add) state.selected.clear();
    points.forEach(i => state.selected.add(i));
    changed();
  };
  const toggle = i => {
    if (!state.selected.delete(i)) state.selected.add(i);
    changed();
  };
  document.addEventListener("keydown", e => { if (e.key === "Escape") { hover(-1); hideTip(); select([]); } });

  // ---- how probably a point conforms; unknown without the uncertainties of the measured values ------------------
  const conformance = data.conformance === null ? null : numbers(data.conformance, Float32Array);
  const percent = p => `${number(100 * p, 3)} %`;

  // ---- the description of one point ----------------------------------------------------------
  const tip = document.getElementById("tip");
  const hideTip = () => { tip.hidden = true; };
  const showTip = (i, x, y) => {
    tip.replaceChildren();
    const failing = columns.filter(c => c.ok && !c.ok[i]).map(c => c.name);
    const head = make("strong", `Point ${ids[i]}`, tip);
    head.after(make("span", !verified[i] && failing.length ? ` fails ${failing.join(", ")}`
      : !data.guarded ? " meets all criteria"
      : verified[i] ? " is accepted" : " is within all tolerances, but in a guard band"));
    if (conformance) make("p", `conforms with a probability of ${percent(conformance[i])}`, tip).className = "quiet";
    const table = make("table", undefined, tip);
    let before = null;
    for (const c of columns) {
      const row = make("tr", undefined, table);
      if (before && !before.ok && c.ok) row.className = "first";
      make("th", c.name, row).scope = "row";
      make("td", number(c.data[i]), row).className = "num";
      make("td", c.unit === "1" ? "" : c.unit, row);
      if (c.ok) {
        const cell = make("td", c.ok[i] ? "✓" : "✗", row);
        cell.className = c.ok[i] ? "tick-mark" : "bad";
        make("td", `${number(deviation(c, i), 2)} × tol.`, row).className = "quiet";
      }
      before = c;
    }
    tip.hidden = false;
    const box = tip.getBoundingClientRect(), gap = 16;
    const room = document.documentElement.clientWidth;
    const left = x + gap + box.width > room - 6 ? x - gap - box.width : x + gap;
    const top = Math.min(Math.max(y - box.height / 2, 6), innerHeight - box.height - 6);
    tip.style.left = `${Math.max(left, 6)}px`;
    tip.style.top = `${top}px`;
  };

  // ---- marks ----------------------------------------------------------------------------------
  const radius = size <= 150 ? 4.5 : size <= 1000 ? 3.5 : size <= 5000 ? 2.5 : 1.8;
  const f = v => v.toFixed(1);
  const shapes = {
    out: (x, y, r) => { const s = r * .75; return `M${f(x - s)},${f(y - s)}l${f(2 * s)},${f(2 * s)}m0,${f(-2 * s)}l${f(-2 * s)},${f(2 * s)}`; },
    part: (x, y, r) => `M${f(x)},${f(y - r)}l${r},${r}l${-r},${r}l${-r},${-r}z`,
    in: (x, y, r) => `M${f(x - r)},${f(y)}a${r},${r} 0 1,0 ${2 * r},0a${r},${r} 0 1,0 ${-2 * r},0`,
  };

  // ---- a plane: one column against another ------------------------------------------------------
  const renderers = [];
  let otherwise = false;
  const WIDTH = 560, HEIGHT = 420, TOP = 30;
  const grouped = n => String(n).replace(/\B(?=(\d{3})+$)/g, ",");
  function plane(figure) {
    const axes = { x: Number(figure.dataset.x), y: Number(figure.dataset.y) };
    const caption = figure.querySelector("figcaption"), picture = figure.querySelector(".picture");
    const note = figure.querySelector(".note");
    const choices = make("span", undefined, caption);
    choices.className = "axes";
    for (const axis of ["y", "x"]) {
      const label = make("label", `${axis} `, choices);
      const choice = make("select", undefined, label);
      columns.forEach((c, k) => { const o = make("option", c.name, choice); o.value = k; o.selected = k === axes[axis]; });
      choice.addEventListener("change", () => { axes[axis] = Number(choice.value); render(); });
    }
    let sx, sy, svg, picks, rings, brush;

    function render() {
      const cx = columns[axes.x], cy = columns[axes.y];
      sx = scale(cx.range, 64, WIDTH - 14);
      sy = scale(cy.range, HEIGHT - 48, TOP);
      picture.replaceChildren();
      svg = draw(picture, "svg", { class: size > 300 ? "plot crowd" : "plot", viewBox: `0 0 ${WIDTH} ${HEIGHT}`, tabindex: 0, role: "application",
        "aria-label": `${cy.title} against ${cx.title}. Arrow keys step through the points, Enter selects.` });
      frame(cx, cy);
      acceptance(cx, cy);
      marks(cx, cy);
      words(cx, cy);
      picks = draw(svg, "path", { class: "picked" });
      rings = draw(svg, "path", { class: "ring" });
      brush = draw(svg, "rect", { class: "brush", visibility: "hidden" });
      listen();
      const hidden = [cx, cy].filter(c => c.outside).map(c => `${c.outside} of ${c.name}`);
      note.textContent = hidden.length ? `Far values outside the axes: ${hidden.join(", ")}.` : "";
      update();
    }

    function frame(cx, cy) {
      for (const t of ticks(sx.low, sx.high, 6)) {
        draw(svg, "path", { class: "grid", d: `M${f(sx.at(t))},${sy.from}V${sy.to}` });
        draw(svg, "text", { class: "tick", x: sx.at(t), y: sy.from + 16, "text-anchor": "middle" }, number(t, 6));
      }
      for (const t of ticks(sy.low, sy.high, 6)) {
        draw(svg, "path", { class: "grid", d: `M${sx.from},${f(sy.at(t))}H${sx.to}` });
        draw(svg, "text", { class: "tick", x: sx.from - 7, y: sy.at(t) + 4, "text-anchor": "end" }, number(t, 6));
      }
      draw(svg, "path", { class: "axis", d: `M${sx.from},${sy.from}H${sx.to}` });
      draw(svg, "text", { class: "title", x: (sx.from + sx.to) / 2, y: HEIGHT - 8, "text-anchor": "middle" }, cx.title);
      draw(svg, "text", { class: "title", transform: `translate(13,${(sy.from + sy.to) / 2}) rotate(-90)`, "text-anchor": "middle" }, cy.title);
    }

    function acceptance(cx, cy) {
      if (!cx.criterion && !cy.criterion) return;
      const box = (kind, [x0, x1], [y0, y1]) => draw(svg, "path", { class: kind, d: `M${f(x0)},${f(y1)}H${f(x1)}V${f(y0)}H${f(x0)}z` });
      const ends = ([low, high], s) => [s.clamp(low), s.clamp(high)];
      const [x0, x1] = ends(tolerance(cx), sx), [y0, y1] = ends(tolerance(cy), sy);
      box(data.guarded ? "tolerance" : "accept", [x0, x1], [y0, y1]);
      const inner = [acceptedRange(cx), acceptedRange(cy)];
      if (data.guarded && inner[0] && inner[1]) box("accept", ends(inner[0], sx), ends(inner[1], sy));
      if (isMeasured(cx)) draw(svg, "path", { class: "nominal", d: `M${f(sx.clamp(cx.criterion.nominal))},${f(y1)}V${f(y0)}` });
      if (isMeasured(cy)) draw(svg, "path", { class: "nominal", d: `M${f(x0)},${f(sy.clamp(cy.criterion.nominal))}H${f(x1)}` });
    }

    function words(cx, cy) {
      let inBox = "";
      if (!crowd && (cx.criterion || cy.criterion)) {
        let n = 0;
        for (let i = 0; i < size; i++) n += completed[i] && inside(cx, i) && inside(cy, i);
        inBox = `, ${grouped(n)} in the box`;
      }
      draw(svg, "text", { class: "tick key", x: sx.from, y: TOP - 8 }, `${grouped(data.total)} points${inBox}${crowd && otherwise ? "" : `, ${grouped(data.accepted)} accepted`}${crowd ? `, ${grouped(size)} drawn` : ""}`);
    }

    const visible = i => sx.has(columns[axes.x].data[i]) && sy.has(columns[axes.y].data[i]);
    const at = i => [sx.at(columns[axes.x].data[i]), sy.at(columns[axes.y].data[i])];

    function marks(cx, cy) {
      const paths = { out: "", part: "", in: "" };
      const boxed = cx.criterion || cy.criterion;
      for (let i = 0; i < size; i++) {
        if (!completed[i] || !visible(i)) continue;
        const kind = verified[i] ? "in" : boxed && inside(cx, i) && inside(cy, i) ? "part" : "out";
        paths[kind] += shapes[kind](...at(i), radius);
      }
      for (const kind in paths) draw(svg, "path", { class: `pt ${kind}`, d: paths[kind] });
    }

    function nearest([x, y], reach) {
      let best = -1, least = reach * reach;
      for (let i = 0; i < size; i++) {
        if (!completed[i] || !visible(i)) continue;
        const [px, py] = at(i), d = (px - x) ** 2 + (py - y) ** 2;
        if (d < least) { least = d; best = i; }
      }
      return best;
    }

    function listen() {
      let start = null;
      svg.addEventListener("pointerdown", e => {
        if (e.button !== 0) return;
        start = local(svg, e);
        svg.setPointerCapture(e.pointerId);
      });
      svg.addEventListener("pointermove", e => {
        const here = local(svg, e);
        if (start && Math.hypot(here[0] - start[0], here[1] - start[1]) > 5) {
          hideTip(); hover(-1);
          const [x, y, w, h] = rectangle(start, here);
          for (const [k, v] of Object.entries({ x, y, width: w, height: h, visibility: "visible" })) brush.setAttribute(k, v);
          return;
        }
        const i = nearest(here, 22);
        hover(i);
        if (i >= 0) showTip(i, e.clientX, e.clientY); else hideTip();
      });
      svg.addEventListener("pointerup", e => {
        if (!start) return;
        const here = local(svg, e), dragged = brush.getAttribute("visibility") === "visible";
        brush.setAttribute("visibility", "hidden");
        if (dragged) {
          const [x, y, w, h] = rectangle(start, here), found = [];
          for (let i = 0; i < size; i++) {
            if (!completed[i] || !visible(i)) continue;
            const [px, py] = at(i);
            if (px >= x && px <= x + w && py >= y && py <= y + h) found.push(i);
          }
          select(found, e.shiftKey);
        } else {
          const i = nearest(here, 22);
          if (i >= 0) toggle(i); else if (!e.shiftKey) select([]);
        }
        start = null;
      });
      svg.addEventListener("pointercancel", () => { start = null; brush.setAttribute("visibility", "hidden"); });
      svg.addEventListener("pointerleave", () => { hover(-1); hideTip(); });
      svg.addEventListener("blur", () => { hover(-1); hideTip(); });
      svg.addEventListener("keydown", keyboard);
    }

    function keyboard(e) {
      const step = { ArrowRight: [1, "x"], ArrowLeft: [-1, "x"], ArrowUp: [1, "y"], ArrowDown: [-1, "y"] }[e.key];
      if ((e.key === "Enter" || e.key === " ") && state.hover >= 0) toggle(state.hover);
      else if (step) {
        const values = columns[axes[step[1]]].data;
        const order = Array.from({ length: size }, (_, i) => i).filter(i => completed[i] && visible(i)).sort((a, b) => values[a] - values[b]);
        if (!order.length) return;
        const now = order.indexOf(state.hover);
        const next = order[now < 0 ? 0 : (now + step[0] + order.length) % order.length];
        hover(next);
        const [px, py] = at(next), box = svg.getBoundingClientRect();
        showTip(next, box.left + px * box.width / WIDTH, box.top + py * box.height / HEIGHT);
      } else return;
      e.preventDefault();
    }

    function update() {
      let d = "";
      state.selected.forEach(i => { if (visible(i)) d += shapes.in(...at(i), radius + 2); });
      picks.setAttribute("d", d);
      rings.setAttribute("d", state.hover >= 0 && visible(state.hover) ? shapes.in(...at(state.hover), radius + 5) : "");
    }
    watchers.push(update);
    renderers.push(render);
    render();
  }
  const rectangle = (a, b) => [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.abs(a[0] - b[0]), Math.abs(a[1] - b[1])];

  // ---- distributions: where the hovered and selected points are ------------------------------------
  function distribution(figure) {
    const c = columns[Number(figure.dataset.column)], svg = figure.querySelector("svg");
    const s = scale(c.range, 42, 258);
    const rug = draw(svg, "path", { class: "rug" }), now = draw(svg, "path", { class: "rug now" });
    watchers.push(() => {
      const stroke = (i, top) => s.has(c.data[i]) ? `M${f(s.at(c.data[i]))},142V${top}` : "";
      rug.setAttribute("d", Array.from(state.selected, i => stroke(i, 128)).join(""));
      now.setAttribute("d", state.hover >= 0 ? stroke(state.hover, 100) : "");
    });
  }

  // ---- parallel axes: combinations --------------------------------------------------------------------
  function parallel(figure) {
    const most = size > 1000 ? 150 : 300, shown = [];
    const evenly = list => { const step = Math.ceil(list.length / most); return list.filter((_, k) => k % Math.max(step, 1) === 0); };
    const whole = Array.from({ length: size }, (_, i) => i).filter(i => completed[i]);
    shown.push(...evenly(whole.filter(i => !verified[i])), ...evenly(whole.filter(i => verified[i])));
    const step = Math.max(96, 1150 / columns.length), width = Math.max(1180, step * columns.length), height = 340, top = 62, bottom = 312;
    const picture = figure.querySelector(".picture");
    picture.className = "picture scroll";
    for (const [key, value] of Object.entries({ tabindex: 0, role: "group", "aria-label": "Combinations of parameters" })) picture.setAttribute(key, value);
    const svg = draw(picture, "svg", { class: "plot", viewBox: `0 0 ${width} ${height}`, role: "img",
      "aria-label": `Parallel axes of ${columns.length} columns; the table of best points tells the same in numbers`, style: `min-width:${Math.min(width, step * columns.length * .75)}px` });
    const rails = columns.map((c, k) => ({ c, x: step * (k + .5) + (width - step * columns.length) / 2, s: scale(c.range, bottom, top) }));
    for (const { c, x, s } of rails) {
      if (c.criterion) {
        const band = (kind, range) => {
          const [a, b] = range.map(s.clamp);
          draw(svg, "path", { class: kind, d: `M${f(x - 9)},${f(a)}H${f(x + 9)}V${f(b)}H${f(x - 9)}z` });
        };
        if (data.guarded) band("tolerance", tolerance(c));
        if (acceptedRange(c)) band("accept", acceptedRange(c));
      }
      draw(svg, "path", { class: "rail", d: `M${f(x)},${top}V${bottom}` });
      const words = parts(c.name);
      draw(svg, "text", { class: "tick", x, y: 14, "text-anchor": "middle" }, words[0]);
      draw(svg, "text", { class: "label", x, y: 30, "text-anchor": "middle" }, words[1]);
      draw(svg, "text", { class: "tick", x, y: top - 8, "text-anchor": "middle" }, `${number(s.high, 4)}${c.unit && c.unit !== "1" ? ` ${c.unit}` : ""}`);
      draw(svg, "text", { class: "tick", x, y: bottom + 18, "text-anchor": "middle" }, number(s.low, 4));
    }
    const thread = i => "M" + rails.map(({ c, x, s }) => `${f(x)},${f(s.clamp(c.data[i]))}`).join("L");
    draw(svg, "path", { class: "thread out", d: shown.filter(i => !verified[i]).map(thread).join("") });
    draw(svg, "path", { class: "thread in", d: shown.filter(i => verified[i]).map(thread).join("") });
    const picks = draw(svg, "path", { class: "thread picked" }), now = draw(svg, "path", { class: "thread now" });
    const brush = draw(svg, "rect", { class: "brush", visibility: "hidden" });
    let start = null;
    svg.addEventListener("pointerdown", e => {
      const [x, y] = local(svg, e), rail = rails.reduce((a, b) => Math.abs(a.x - x) < Math.abs(b.x - x) ? a : b);
      start = { rail, y };
      svg.setPointerCapture(e.pointerId);
    });
    const span = e => { const y = local(svg, e)[1]; return [Math.min(y, start.y), Math.max(y, start.y)]; };
    svg.addEventListener("pointermove", e => {
      if (!start) return;
      const [a, b] = span(e);
      for (const [k, v] of Object.entries({ x: start.rail.x - 12, width: 24, y: a, height: b - a, visibility: "visible" })) brush.setAttribute(k, v);
    });
    svg.addEventListener("pointerup", e => {
      if (!start) return;
      const [a, b] = span(e), { c, s } = start.rail;
      brush.setAttribute("visibility", "hidden");
      select(b - a < 4 ? [] : whole.filter(i => { const y = s.clamp(c.data[i]); return y >= a && y <= b; }), e.shiftKey);
      start = null;
    });
    watchers.push(() => {
      picks.setAttribute("d", Array.from(state.selected).slice(0, 400).map(thread).join(""));
      now.setAttribute("d", state.hover >= 0 ? thread(state.hover) : "");
    });
  }

  // ---- the list of selected points -----------------------------------------------------------------------
  function selection(section) {
    const counter = document.getElementById("selection-count"), holder = document.getElementById("selection-table");
    const LISTED = 200;
    document.getElementById("clear").addEventListener("click", () => select([]));
    document.getElementById("select-verified").addEventListener("click", () => select(Array.from(ids, (_, i) => i).filter(i => verified[i])));
    document.getElementById("download").addEventListener("click", () => {
      // A spreadsheet would take such a name for a formula.
      const plain = t => /^'*[=+\-@\t\r]/.test(t) ? `'${t}` : t;
      const quote = t => /[",\r\n]/.test(plain(t)) ? `"${plain(t).replace(/"/g, '""')}"` : plain(t);
      const lines = [["point", ...columns.map(c => c.title), word, ...(conformance ? ["conformance"] : [])].map(quote).join(",")];
      const chosen = state.selected.size ? [...state.selected] : Array.from(ids, (_, i) => i);
      chosen.forEach(i => lines.push([ids[i], ...columns.map(c => Number(c.data[i].toPrecision(7))), verified[i] === 1, ...(conformance ? [Number(conformance[i].toPrecision(4))] : [])].join(",")));
      const link = make("a");
      link.href = URL.createObjectURL(new Blob([lines.join("\n") + "\n"], { type: "text/csv" }));
      link.download = "selected-points.csv";
      link.click();
      URL.revokeObjectURL(link.href);
    });
    let before = "";
    watchers.push(() => {
      const chosen = [...state.selected].sort((a, b) => ids[a] - ids[b]);
      const key = chosen.join();
      if (key === before) return;
      before = key;
      const passing = chosen.filter(i => verified[i]).length;
      counter.textContent = chosen.length ? `${chosen.length} selected, ${passing} of them ${word}.${chosen.length > LISTED ? ` The first ${LISTED} are listed.` : ""}` : "None selected.";
      section.classList.toggle("nothing-selected", !chosen.length);
      holder.replaceChildren();
      if (!chosen.length) return;
      const table = make("table", undefined, holder), head = make("tr", undefined, make("thead", undefined, table));
      make("th", "Point", head).scope = "col";
      if (conformance) make("th", "Conforms", head).scope = "col";
      for (const c of columns) heading(c, make("th", undefined, head));
      const body = make("tbody", undefined, table);
      for (const i of chosen.slice(0, LISTED)) {
        const row = make("tr", undefined, body);
        row.dataset.id = ids[i];
        make("th", `${ids[i]}${verified[i] ? " ✓" : ""}`, row).scope = "row";
        if (conformance) make("td", percent(conformance[i]), row).className = "num";
        for (const c of columns) make("td", number(c.data[i]), row).className = c.ok && !c.ok[i] ? "num bad" : "num";
      }
    });
    section.classList.add("nothing-selected");
  }

  // ---- rows of tables are points too -------------------------------------------------------------------------
  const rowPoint = e => { const row = e.target.closest?.("tr[data-id]"); return row ? indexOf.get(Number(row.dataset.id)) ?? -1 : -1; };
  document.addEventListener("mouseover", e => { if (e.target.closest?.("tr[data-id]")) hover(rowPoint(e)); });
  document.addEventListener("mouseout", e => { if (e.target.closest?.("tr[data-id]")) hover(-1); });
  document.addEventListener("click", e => { const i = rowPoint(e); if (i >= 0) toggle(i); });
  watchers.push(() => document.querySelectorAll("tr[data-id]").forEach(row => {
    const i = indexOf.get(Number(row.dataset.id));
    row.classList.toggle("hover", i === state.hover);
    row.classList.toggle("selected", state.selected.has(i));
  }));

  // ---- tables whose rows stand below themselves on small screens -----------------------------------------------
  const labelled = table => {
    const heads = [...table.querySelectorAll("thead th, thead td")].map(head => head.textContent);
    table.querySelectorAll("tbody tr").forEach(row => [...row.cells].forEach((cell, k) => { cell.dataset.label = heads[k]; }));
  };
  document.querySelectorAll(".stack").forEach(labelled);

  // ---- sections fold; on small screens only the first ones are open ---------------------------------------------
  const narrow = matchMedia("(max-width: 640px)").matches;
  const folds = new Map([...document.querySelectorAll("main > section:not(#verdict)")].map(section => {
    const title = section.querySelector("h2"), button = make("button");
    button.type = "button";
    button.className = "fold";
    button.append(...title.childNodes);
    title.append(button);
    const fold = folded => {
      section.classList.toggle("folded", folded);
      button.setAttribute("aria-expanded", !folded);
    };
    fold(narrow && section.id !== "counts" && !section.querySelector(".tune"));
    button.addEventListener("click", () => fold(!section.classList.contains("folded")));
    return [section.id, fold];
  }));
  const unfold = () => folds.get(location.hash.slice(1))?.(false);
  addEventListener("hashchange", unfold);
  unfold();

  if (narrow) document.querySelectorAll(".rest").forEach(rest => { rest.open = false; });

  // ---- print with everything open ------------------------------------------------------------------------------
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach(d => { d.open = true; }));

  document.documentElement.classList.add("live");
  document.querySelectorAll("figure.plane").forEach(plane);
  document.querySelectorAll("figure.distribution").forEach(distribution);
  document.querySelectorAll("#parallel figure").forEach(parallel);
  selection(document.getElementById("selection"));

  // ---- what if: the plots follow another setting of the study ------------------------------------------------------
  const redraw = ({ changed: differs, guarded, accepted, verified: flags }) => {
    verified = flags;
    otherwise = differs;
    Object.assign(data, { guarded, accepted: crowd ? data.accepted : accepted });
    document.documentElement.classList.toggle("changed", differs);
    document.getElementById("changed-note").hidden = !differs;
    renderers.forEach(render => render());
    changed();
  };
  WhatIf.start({ data, columns, completed, bytes, make, number, grouped, labelled, redraw });
})();
