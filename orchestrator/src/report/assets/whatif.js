"use strict";
// The panel "What if": controls, and what follows from them. `page` is what the rest of the page's script lends:
// { data, columns, completed, bytes, make, number, grouped, labelled, redraw }.
const WhatIf = (() => {
  const clone = value => JSON.parse(JSON.stringify(value));
  // As many digits as a hand on a slider can mean.
  const rounded = v => Number(v.toPrecision(5));
  let page, study, points, setting, changes, found;

  // ---- what is asked ------------------------------------------------------------------------------------------
  const begin = () => {
    setting = clone({ criteria: study.criteria, correlations: study.correlations, rule: study.rule });
    changes = {};
  };
  const differs = () => Object.keys(changes).length > 0
    || JSON.stringify([setting.criteria, setting.rule]) !== JSON.stringify([study.criteria, study.rule]);

  // The case of each criterion; they are all of one in a study without cases.
  const cases = () => study.criteria.map(({ name }) => study.cases ? name.split("/")[0] : "");
  // The points that are judged: all that the page holds, or the even choice among them.
  const choose = () => {
    const { data, columns, completed } = page;
    const chosen = data.sample ? Array.from(page.bytes(data.sample), (is, i) => is ? i : -1).filter(i => i >= 0) : null;
    const pick = list => chosen ? list.constructor.from(chosen, i => list[i]) : list;
    const own = columns.filter(c => c.criterion), size = chosen ? chosen.length : completed.length;
    points = {
      size, samples: study.samples, grid: study.grid, completed: pick(completed),
      values: own.map(c => pick(c.data)),
      parameters: columns.filter(c => !c.criterion).map(c => pick(c.data)),
    };
    points.known = Judge.known(cases(), points.values);
  };

  // ---- what follows -------------------------------------------------------------------------------------------------
  const evaluate = () => {
    const result = Judge.judge(setting, points);
    found = result;
    if (Object.keys(changes).length) {
      const weights = Weights.of(study.parameters, changes, points.parameters, points.size);
      found = Reweigh.judge(setting, points, result, weights, page.data.total);
    }
    // Some of the points can show that one is accepted, but not that none is, and not that all of them decide nothing.
    const open = setting.rule ? found.verdict === "inconclusive" : found.verdict === "not verified";
    if (page.data.sample && open && found.failed < found.points) found.verdict = "not decided";
    return found;
  };

  // ---- the plots follow -----------------------------------------------------------------------------------------------
  const applyToPlots = () => {
    const band = found.guard_band, own = page.columns.filter(c => c.criterion), known = Judge.known(cases(), own.map(c => c.data)), margins = new Float64Array(page.completed.length).fill(Infinity);
    own.forEach((c, k) => {
      const criterion = setting.criteria[k], [lower, upper] = Judge.ends(criterion), by = (band ?? Infinity) * (criterion.uncertainty?.expanded ?? 0);
      const inner = [lower + by, upper - by], alone = !Number.isFinite(upper - lower);
      c.criterion.shown ??= { ...c.criterion };
      // The value with the deviation 0 moves with a limit that stands alone.
      const nominal = alone ? c.criterion.shown.nominal + criterion.nominal - study.criteria[k].nominal : criterion.nominal;
      Object.assign(c.criterion, { nominal, lower, upper, drawn_in: inner[0] <= inner[1] ? inner : null });
      c.ok = Uint8Array.from(c.data, (value, i) => known[k][i] && Judge.within(criterion, value) >= 0 ? 1 : 0);
      for (let i = 0; i < margins.length; i++) margins[i] = Math.min(margins[i], page.completed[i] ? Judge.margin(criterion, c.data[i]) : -Infinity);
    });
    const verified = Uint8Array.from(margins, m => band !== null && m >= band ? 1 : 0);
    page.redraw({ changed: differs(), guarded: band !== 0, accepted: found.accepted, verified });
  };

  // ---- the changed study as text -------------------------------------------------------------------------------------------
  const edits = () => {
    const list = [];
    setting.criteria.forEach((c, k) => {
      const before = study.criteria[k];
      if (JSON.stringify(c) === JSON.stringify(before)) return;
      // All as numbers in the criterion's unit: a tolerance in per cent would follow the measured value.
      const [minus, plus] = Judge.reach(c), even = minus === plus;
      const values = c.curve ? c.nominal === 1 ? { least: rounded(1 - minus) } : { tolerance: plus } : minus === Infinity ? { "at-most": c.nominal } : plus === Infinity ? { "at-least": c.nominal }
        : { nominal: c.nominal, tolerance: even ? plus : `{ minus = ${minus}, plus = ${plus} }` };
      const factor = c.uncertainty?.expanded / before.uncertainty?.expanded, parts = before.uncertainty?.parts ?? [];
      if (!c.derived) for (const [key, part] of parts) values[key] = key === "gain-uncertainty" ? `"${part * factor} %"` : part * factor;
      // Alone it is what is shown, to the last digit.
      if (parts.length === 1 && values.uncertainty && !c.uncertainty.law) values.uncertainty = c.uncertainty.expanded;
      const [name, inCase] = c.name.split("/").reverse();
      if (study.cases && inCase) list.push({ inCase, name, values: { ...values, ...(before.unit && { unit: JSON.stringify(before.unit) }) } });
      else list.push({ path: ["criteria", c.name], values });
    });
    if (setting.rule && JSON.stringify(setting.rule) !== JSON.stringify(study.rule)) list.push({ path: ["verdict"], values: { share: setting.rule.share }, mayBeNew: true });
    const named = page.columns.filter(c => !c.criterion);
    Object.entries(changes).forEach(([k, values]) => {
      // The study may have its unit only in a text such as "0.08 mm", which the number takes the place of.
      const { name, unit } = named[k];
      list.push({ path: ["parameters", name], values: { ...values, ...(unit && unit !== "1" && { unit: JSON.stringify(unit) }) } });
    });
    return list;
  };

  // ---- controls -----------------------------------------------------------------------------------------------------------------
  // A slider with a field for the exact number; `scale` turns the slider's position from -1 to 1 into a number and back.
  const control = (parent, words, { get, set, scale, title }) => {
    const { make } = page, row = make("label", undefined, parent);
    row.className = "control";
    make("span", words, row);
    const slider = make("input", undefined, row), field = make("input", undefined, row);
    Object.assign(slider, { type: "range", min: -1, max: 1, step: 0.005 });
    Object.assign(field, { type: "number", step: "any" });
    slider.setAttribute("aria-label", `${title}: ${words}`);
    field.setAttribute("aria-label", `${title}: ${words}, exactly`);
    const show = () => {
      slider.value = scale.place(get());
      if (document.activeElement !== field) field.value = Number(get().toPrecision(10));
    };
    slider.addEventListener("input", () => { set(rounded(scale.number(Number(slider.value)))); changed(); });
    field.addEventListener("input", () => {
      const value = field.valueAsNumber;
      if (Number.isFinite(value) && scale.allows(value)) { set(value); changed(); }
    });
    shows.push(show);
  };
  const shows = [];
  const linear = (centre, reach) => ({ number: p => centre + p * reach, place: v => (v - centre) / reach, allows: () => true });
  const powers = (centre, factor) => ({ number: p => centre * factor ** p, place: v => Math.log(v / centre) / Math.log(factor), allows: v => v > 0 });
  const within = (low, high) => ({ number: p => low + (p + 1) / 2 * (high - low), place: v => 2 * (v - low) / (high - low) - 1, allows: v => v >= low && v <= high });

  const titled = (name, unit) => unit && unit !== "1" ? `${name} (${unit})` : name;
  // The tolerance of a curve stands below its picture.
  const curveControl = (start, k) => {
    const box = document.querySelector(`.tune[data-criterion="${CSS.escape(start.name)}"]`);
    if (!box) return;
    // Equal curves have the value 0, or 1 of a rating.
    const own = () => setting.criteria[k], title = titled(start.name, start.unit), rating = start.nominal === 1;
    const key = start.tolerance !== undefined ? "tolerance" : rating ? "minus" : "plus";
    if (rating) control(box, "at least", { title, get: () => 1 - own()[key], set: v => { own()[key] = 1 - v; }, scale: within(0, 1) });
    else control(box, "tolerance: at most", { title, get: () => own()[key], set: v => { own()[key] = v; }, scale: powers(start[key], 8) });
    const told = page.make("p", undefined, box);
    told.className = "note";
    told.setAttribute("aria-live", "polite");
    shows.push(() => {
      const changed = JSON.stringify(own()) !== JSON.stringify(start) ? " The risk stands for the study's own tolerance: another one takes the model's curves, so run the changed study." : "";
      told.textContent = `${page.grouped(found.criteria[k].passed)} of ${page.grouped(found.points)} points meet it, ${page.grouped(found.accepted)} all criteria.${changed}`;
    });
  };
  const criterionControls = parent => study.criteria.forEach((start, k) => {
    if (start.curve) return curveControl(start, k);
    const box = page.make("fieldset", undefined, parent), title = titled(start.name, start.unit);
    page.make("legend", title, box);
    const own = () => setting.criteria[k];
    const [minus, plus] = Judge.reach(start), room = start.unit_of_distance ?? Math.max(minus, plus);
    const words = minus === Infinity ? "at most" : plus === Infinity ? "at least" : "measured value";
    control(box, words, { title, get: () => own().nominal, set: v => { own().nominal = v; }, scale: linear(start.nominal, 3 * room) });
    const sides = start.tolerance ? { tolerance: "tolerance ±" } : { minus: "tolerance −", plus: "tolerance +" };
    if (Number.isFinite(minus + plus)) for (const [key, label] of Object.entries(sides)) {
      control(box, label, { title, get: () => own()[key], set: v => { own()[key] = v; }, scale: powers(start[key], 8) });
    }
    if (start.uncertainty && !start.derived) {
      const { law, coverage } = start.uncertainty;
      control(box, law ? "uncertainty, 95 %" : `uncertainty, k = ${page.number(coverage, 4)}`, {
        title, get: () => own().uncertainty.expanded, set: v => { own().uncertainty.expanded = v; }, scale: powers(start.uncertainty.expanded, 8),
      });
    }
  });
  const ruleControls = parent => {
    const box = page.make("fieldset", undefined, parent);
    page.make("legend", "required share", box);
    if (!study.rule) {
      const label = page.make("label", undefined, box), tick = page.make("input", undefined, label);
      tick.type = "checkbox";
      label.append(" required, instead of one point");
      label.className = "control";
      tick.addEventListener("change", () => {
        setting.rule = tick.checked ? { share: 0.05, confidence: 0.95, band: 0 } : null;
        changed();
      });
      shows.push(() => { tick.checked = setting.rule !== null; });
    }
    const share = () => rounded(100 * (setting.rule?.share ?? 0.05));
    control(box, "per cent of the space", {
      title: "required share", get: share,
      set: v => { setting.rule ??= { share: 0.05, confidence: 0.95, band: 0 }; setting.rule.share = rounded(v) / 100; },
      scale: { number: p => 10 ** (1.5 * p + 0.4), place: v => (Math.log10(v) - 0.4) / 1.5, allows: v => v > 0 && v < 100 },
    });
  };
  const parameterControls = parent => {
    const named = page.columns.filter(c => !c.criterion);
    study.parameters.forEach((start, k) => {
      if (!Weights.possible(start)) return;
      const box = page.make("fieldset", undefined, parent), title = titled(named[k].name, named[k].unit);
      page.make("legend", title, box);
      const own = key => changes[k]?.[key] ?? start[key];
      const set = (key, value) => {
        changes[k] = { mean: own("mean"), deviation: own("deviation"), [key]: value };
        if (changes[k].mean === start.mean && changes[k].deviation === start.deviation) delete changes[k];
      };
      const reach = Weights.REACH.mean * start.deviation, [least, most] = Weights.REACH.deviation;
      control(box, "mean", { title, get: () => own("mean"), set: v => set("mean", v), scale: within(start.mean - reach, start.mean + reach) });
      control(box, "deviation", { title, get: () => own("deviation"), set: v => set("deviation", v), scale: within(least * start.deviation, most * start.deviation) });
    });
  };

  // ---- what is shown ---------------------------------------------------------------------------------------------------------------
  const percent = share => share === null || share === undefined ? "–" : page.number(100 * share, 4);
  const ends = interval => interval ? `${percent(interval[0])} .. ${percent(interval[1])}` : "";
  let outcome, table, warning, snippet, saved;
  const capital = text => text[0].toUpperCase() + text.slice(1);
  const sentence = () => {
    const weighted = found.effective !== undefined;
    const known = found.guard_band !== null || found.jointKnown;
    if (!known) return "The guard band is not computed here.";
    const count = weighted ? "" : `${page.grouped(found.accepted)} of ${page.grouped(found.points)} points, `;
    const interval = setting.rule ? found.interval : found.acceptedShare.interval, level = 100 * (setting.rule?.confidence ?? 0.95);
    const range = interval ? ` (${page.number(level, 4)} % interval ${ends(interval)} %)` : "";
    const band = found.guard_band ? ` Every tolerance is drawn in by a guard band of ${page.number(found.guard_band, 3)} expanded uncertainties.` : found.guard_band === null ? " No guard band keeps the risk as low as required." : "";
    const wrong = found.risk?.not_conforming_given_accepted;
    const risk = Number.isFinite(wrong) ? ` Of the accepted points ${percent(wrong)} % probably do not conform.` : "";
    return `${count}${percent(found.acceptedShare.fraction)} % of the space accepted${range}.${band}${risk}`;
  };
  const warnings = () => {
    const list = [];
    if (page.data.sample) list.push(`From an even choice of ${page.grouped(points.size)} of the ${page.grouped(page.data.total)} points${points.grid ? "" : "; the intervals count these"}.`);
    if (found.effective !== undefined) {
      list.push(`Other distributions by weights: the points count as ${page.grouped(Math.round(found.effective))} of ${page.grouped(points.size)}.`);
      if (setting.rule?.risk !== undefined) list.push("A fresh study would find a guard band of its own; the one here is an estimate, and the verdict and its interval hold for any that the required risk allows.");
      if (found.some) list.push(`If the points of a fresh study were independent, at least one of ${page.grouped(page.data.total)} would be accepted with a probability of ${ends(found.some)} %.`);
      if (found.effective < Weights.FEW) list.push("That is too few to rely on: run the changed study.");
    }
    if (found.verdict === "not decided") list.push(differs() ? "Run the changed study to decide." : "The verdict above is that of the whole study.");
    if (study.looked_again && setting.rule) list.push("This study was looked at more than once; the verdict here is that of one look and surer than it may be.");
    if (differs() && study.criteria.some(c => c.derived)) list.push("The errors of derived measured values stay as they are here; judge the changed study.");
    if (!found.jointKnown) list.push("Three or more measured values are correlated: the risks of all criteria together are not computed here; judge the changed study.");
    return list.join(" ");
  };
  const show = () => {
    const { make } = page;
    outcome.replaceChildren();
    // Some of the points, or one look of several, need not come to the study's own verdict.
    const asStated = page.data.sample ? "From some of the points: " : study.looked_again ? "By one look: " : "As the study stands: ";
    make("strong", `${differs() ? "What if: " : asStated}${found.verdict}. `, outcome);
    outcome.append(capital(sentence()));
    warning.textContent = warnings();
    warning.classList.toggle("warning", found.effective < Weights.FEW);
    table.replaceChildren();
    const head = make("tr", undefined, make("thead", undefined, table));
    ["Criterion", "Points", "Share %", "95 % interval", "Cm", "Consumer's risk %", "Producer's risk %", "Not conforming % of accepted"]
      .forEach((words, k) => { const th = make("th", words, head); th.scope = "col"; if (k) th.className = "num"; });
    const body = make("tbody", undefined, table), weighted = found.effective !== undefined;
    const row = (name, count, risk, capability, total) => {
      const tr = make("tr", undefined, body);
      if (total) tr.className = "total";
      make("th", name, tr).scope = "row";
      const cells = [weighted ? "–" : page.grouped(count.passed), percent(count.fraction), ends(count.interval), capability ? page.number(capability, 3) : "",
        percent(risk?.consumer), percent(risk?.producer), percent(risk?.not_conforming_given_accepted)];
      cells.forEach(text => { make("td", text, tr).className = "num"; });
    };
    found.criteria.forEach((c, k) => row(setting.criteria[k].name, c, c.risk, c.capability));
    found.groups.forEach(group => row(`group ${group.name}`, group));
    row("all criteria", found.verified, found.guard_band === 0 ? found.risk : null, null, true);
    if (found.guard_band !== 0) row("accepted", { passed: found.accepted, fraction: found.acceptedShare.fraction, interval: found.acceptedShare.interval }, found.risk, null, true);
    page.labelled(table);
    const list = edits();
    snippet.textContent = list.length ? Toml.snippet(list) : "# nothing is changed";
    const whole = Toml.edited(study.text, list);
    saved.hidden = !whole;
    page.elements.hint.textContent = whole ? "" : list.some(change => change.inCase)
      ? "Criteria of single cases are changed by hand: the lines above say where."
      : "These tables are written in another way in the study: put the lines there by hand.";
    shows.forEach(refresh => refresh());
  };
  // The verdict follows every movement; the plots, which take longer, come when there is time.
  let waiting = false, drawing = 0;
  const changed = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      evaluate();
      show();
      clearTimeout(drawing);
      drawing = setTimeout(applyToPlots, 30);
    });
  };
  const update = () => { evaluate(); show(); applyToPlots(); };

  // ---- the whole panel ---------------------------------------------------------------------------------------------------------------
  const save = () => {
    const link = page.make("a");
    link.href = URL.createObjectURL(new Blob([text()], { type: "application/toml" }));
    link.download = "what-if.toml";
    link.click();
    URL.revokeObjectURL(link.href);
  };
  /** The changed study, where its text could be changed. */
  const text = () => Toml.edited(study.text, edits());
  const start = lent => {
    page = lent;
    study = page.data.study;
    const section = document.getElementById("whatif");
    if (!study || !section) return;
    const part = name => section.querySelector(`.${name}`);
    [outcome, table, warning, snippet, saved] = ["outcome", "results", "caution", "snippet", "save"].map(part);
    page.elements = { hint: part("by-hand") };
    for (const c of study.criteria) if (c.minus !== null && c.minus === c.plus) c.tolerance = c.plus;
    begin();
    choose();
    criterionControls(part("criteria"));
    ruleControls(part("criteria"));
    if (study.fixed) page.make("p", `The distributions of the parameters cannot be changed here: ${study.fixed}.`, part("parameters")).className = "hint";
    else parameterControls(part("parameters"));
    part("reset").addEventListener("click", () => { begin(); update(); });
    saved.addEventListener("click", save);
    evaluate();
    show();
  };

  /** Changes the study by numbers, and returns what follows: { criteria: { NAME: { nominal, tolerance, minus, plus, expanded } }, share,
   * parameters }; `nominal` is the limit where it stands alone. */
  const ask = ({ criteria = {}, share, parameters = {} }) => {
    begin();
    for (const [name, { expanded, ...numbers }] of Object.entries(criteria)) {
      const own = setting.criteria.find(c => c.name === name);
      Object.assign(own, numbers);
      if (expanded) own.uncertainty.expanded = expanded;
    }
    if (share) setting.rule = { ...(setting.rule ?? { confidence: 0.95, band: 0 }), share };
    const names = page.columns.filter(c => !c.criterion).map(c => c.name);
    for (const [name, values] of Object.entries(parameters)) changes[names.indexOf(name)] = values;
    update();
    const { flags, ...rest } = found;
    return { ...rest, text: text() };
  };

  return { start, ask };
})();
