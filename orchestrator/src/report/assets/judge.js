"use strict";
// Judges points as `orchestrator judge` does: counts, shares, risks, guard band, verdict.
//
// A setting is { criteria, correlations, rule }: of each criterion { name, nominal, tolerance, uncertainty, group }, in place of
// the tolerance also { minus, plus }, null where there is no such limit; the uncertainty { expanded, coverage } or null, with the
// `law` of its error where that is not normal; of the rule { share, confidence, band } or { share, confidence, risk }, or null
// where one point is enough. Points are { size, completed, values, samples, grid }: the values by criterion, and the number of
// randomisations of the design to which the points belong in turn.
const Judge = (() => {
  const STEP = 1e-3, MOST_STEPS = 1e4, LEVEL = 0.95;

  // ---- one value ------------------------------------------------------------------------------------------
  const reach = c => [c.tolerance ?? c.minus ?? Infinity, c.tolerance ?? c.plus ?? Infinity];
  const ends = c => {
    const [minus, plus] = reach(c);
    return [c.nominal - minus, c.nominal + plus];
  };
  const half = c => 0.5 * (reach(c)[0] + reach(c)[1]);
  const within = (criterion, value) => {
    const [minus, plus] = reach(criterion), deviation = value - criterion.nominal;
    return Math.min(plus - deviation, minus + deviation);
  };
  const margin = (criterion, value) => inUncertainties(criterion, within(criterion, value));
  const inUncertainties = ({ uncertainty }, rest) => {
    if (Number.isNaN(rest)) return -Infinity;
    if (uncertainty) return rest / uncertainty.expanded;
    return rest >= 0 ? Infinity : -Infinity;
  };
  // The errors of the measured value with which a value conforms; as normal scores; and how probable they are.
  const errorsOf = (criterion, value) => {
    const [minus, plus] = reach(criterion), deviation = value - criterion.nominal;
    return [deviation - plus, deviation + minus];
  };
  const standard = ({ expanded, coverage, law }) => expanded * (law ? Math.hypot(law.normal, law.student, law.half_width / Math.sqrt(3)) : 1 / coverage);
  const limits = (criterion, value) => {
    const { uncertainty } = criterion, { law, expanded } = uncertainty;
    return errorsOf(criterion, value).map(error => law ? Numbers.score(law, error / expanded) : error / standard(uncertainty));
  };
  const chanceOf = (criterion, value) => {
    const { law, expanded } = criterion.uncertainty;
    return law ? Numbers.errorBetween(law, ...errorsOf(criterion, value).map(error => error / expanded)) : Numbers.between(...limits(criterion, value));
  };
  const capability = c => c.uncertainty && Number.isFinite(half(c)) ? half(c) / (2 * standard(c.uncertainty)) : null;

  // ---- joint probabilities -----------------------------------------------------------------------------------
  /** How errors hang together: single ones, pairs, and copies of others; null where three or more depend on each other. */
  const errors = (count, correlations) => {
    const partners = Array.from({ length: count }, () => []);
    for (const [a, b, r] of correlations) {
      if (r === 0) continue;
      partners[a].push([b, r]);
      partners[b].push([a, r]);
    }
    if (partners.some(list => list.length > 1)) return null;
    const blocks = [];
    partners.forEach((list, a) => {
      if (!list.length) blocks.push([a]);
      else if (a < list[0][0]) blocks.push([a, ...list[0]]);
    });
    return blocks;
  };
  const joint = (blocks, lower, upper) => {
    let product = 1;
    for (const [a, b, r] of blocks) {
      if (b === undefined) product *= Numbers.between(lower[a], upper[a]);
      else if (Math.abs(r) === 1) {
        const ends = [r * lower[b], r * upper[b]];
        product *= Numbers.between(Math.max(lower[a], Math.min(...ends)), Math.min(upper[a], Math.max(...ends)));
      } else product *= Numbers.betweenBoth([lower[a], lower[b]], [upper[a], upper[b]], r);
    }
    return product;
  };

  // ---- the points that guard bands accept ----------------------------------------------------------------------
  // The widest band, in steps, that lets a point pass; -1 outside of the tolerances.
  const widest = (rule, ofMargin) => {
    if (rule?.risk === undefined) return ofMargin >= (rule?.band ?? 0) ? 0 : -1;
    const steps = Math.min(ofMargin / STEP, MOST_STEPS);
    return steps >= 0 ? Math.floor(steps) : -1;
  };
  const tally = (samples, known) => ({ samples, known, within: new Map(), outside: Array.from({ length: samples }, Moments.none) });
  const add = (acceptance, step, sample, notConforming) => {
    let place = acceptance.outside;
    if (step >= 0) {
      place = acceptance.within.get(step);
      if (!place) acceptance.within.set(step, place = Array.from({ length: acceptance.samples }, Moments.none));
    }
    Moments.take(place[sample], notConforming);
  };
  const stepsDown = acceptance => [...acceptance.within.keys()].sort((a, b) => b - a);
  // The least probability of accepted points not to conform that any guard band comes to, over these points.
  const leastRisk = acceptance => {
    const accepted = Moments.none();
    return stepsDown(acceptance).reduce((least, step) => {
      Moments.merge(accepted, Moments.total(acceptance.within.get(step)));
      return Math.min(least, Moments.mean(accepted));
    }, 1);
  };
  const split = (acceptance, from) => {
    const accepted = Array.from({ length: acceptance.samples }, Moments.none);
    const rejected = acceptance.outside.map(part => ({ ...part }));
    for (const [step, parts] of acceptance.within) {
      const side = step >= from ? accepted : rejected;
      parts.forEach((part, k) => Moments.merge(side[k], part));
    }
    return { accepted, rejected };
  };
  const risk = (acceptance, from, grid) => {
    if (!acceptance.known) return null;
    const { accepted, rejected } = split(acceptance, from);
    const ofAll = of => accepted.map((a, k) => Moments.among(of(a, rejected[k]), a.count + rejected[k].count));
    const consumer = ofAll(a => a), producer = ofAll((_, r) => Moments.complement(r));
    const conforming = ofAll((a, r) => Moments.complement(Moments.merge({ ...a }, r)));
    const mean = parts => Moments.mean(Moments.total(parts));
    const any = Moments.total(accepted).count > 0;
    return {
      consumer: mean(consumer),
      producer: mean(producer),
      conformance_probability: mean(conforming),
      not_conforming_given_accepted: any ? mean(accepted) : null,
      intervals: grid ? null : {
        consumer: Moments.ofMean(consumer, LEVEL),
        producer: Moments.ofMean(producer, LEVEL),
        conformance_probability: Moments.ofMean(conforming, LEVEL),
        not_conforming_given_accepted: Moments.ofPart(accepted, LEVEL),
      },
    };
  };

  // ---- the guard bands that may be the right one of the whole space (`conformity::risk::bands`) ---------------------
  const counts = parts => parts.map(part => part.count);
  // The largest probability not to conform of any values with at least this margin, by Boole's inequality.
  const worst = (criteria, ofMargin) => {
    const each = criterion => {
      if (!criterion.uncertainty) return 1;
      const by = Math.min(ofMargin * criterion.uncertainty.expanded, half(criterion)), [lower, upper] = ends(criterion);
      return 1 - chanceOf(criterion, Number.isFinite(upper) ? upper - by : lower + by);
    };
    return Math.min(criteria.reduce((sum, criterion) => sum + each(criterion), 0), 1);
  };
  const bandSets = (acceptance, criteria) => {
    const parts = Array.from({ length: acceptance.samples }, Moments.none), steps = stepsDown(acceptance);
    return steps.map((step, k) => {
      acceptance.within.get(step).forEach((part, sample) => Moments.merge(parts[sample], part));
      const own = [k + 1 < steps.length ? steps[k + 1] + 1 : 0, step];
      return { steps: own, worst: own.map(s => worst(criteria, s * STEP)), parts: parts.map(part => ({ ...part })) };
    });
  };
  const setInterval = ({ worst: [most], parts }, confidence) =>
    Moments.ofPart(parts.map(part => Moments.scaled(part, 1 / most)), confidence).map(end => end * most);
  const allowedBands = (acceptance, criteria, limit, confidence, grid) => {
    const sets = bandSets(acceptance, criteria), size = set => Moments.total(set.parts).count;
    let first = sets.length - 1;
    while (!grid && first >= 0 && setInterval(sets[first], confidence)[0] > limit) first--;
    const fewest = Math.ceil(10 / limit), many = sets.length > 0 && size(sets[sets.length - 1]) >= fewest;
    let enough = null, widest = null;
    for (const set of sets) {
      if (set.worst[1] <= limit) [enough, widest] = [set, set.steps[1]];
      if (set.worst[0] > limit) {
        if (many && size(set) < fewest) continue;
        // Points that are no sample show of no band that it is enough.
        if (grid || setInterval(set, confidence)[1] > limit) break;
      }
      [enough, widest] = [set, set.steps[0]];
    }
    const none = Array(acceptance.samples).fill(0);
    return { widest, least: enough ? counts(enough.parts) : none, most: first < 0 ? none : counts(sets[first].parts) };
  };

  // ---- the verdict -----------------------------------------------------------------------------------------------
  const decide = (rule, [low, high]) => low >= rule.share ? "verified" : high < rule.share ? "not verified" : "inconclusive";
  const byBands = (rule, bands, points) => {
    const [low] = Moments.ofCounts(bands.least, points, rule.confidence);
    const [, high] = Moments.ofCounts(bands.most, points, rule.confidence);
    const verdicts = [bands.least, bands.most].map(of => decide(rule, Moments.ofCounts(of, points, rule.confidence)));
    const verdict = verdicts[0] === "verified" ? "verified" : verdicts[1] === "not verified" ? "not verified" : "inconclusive";
    return { verdict, interval: [low, high] };
  };
  /** The narrowest band, in steps, that keeps the risk at or below a limit for any distribution of the points; Infinity if none. */
  const sureStep = (criteria, limit) => {
    if (worst(criteria, MOST_STEPS * STEP) > limit) return Infinity;
    let low = -1, high = MOST_STEPS;
    while (high - low > 1) {
      const middle = Math.floor((low + high) / 2);
      if (worst(criteria, middle * STEP) <= limit) high = middle; else low = middle;
    }
    return high;
  };
  const undecided = ({ verdict, interval }) => ({ verdict: verdict === "inconclusive" ? "not decided" : verdict, interval });
  // Where no point can be accepted, although some are within all tolerances.
  const unfit = (rule, within, points) => {
    const interval = Moments.ofCounts(within, points, rule.confidence);
    const no = decide(rule, interval) === "not verified";
    return no ? { verdict: "not verified", interval: [0, interval[1]] } : { verdict: "inconclusive", interval: null };
  };
  const conclude = (rule, bands, accepted, within, points, cannot) => {
    if (!rule) return { verdict: accepted > 0 ? "verified" : "not verified", interval: null };
    return cannot ? unfit(rule, within, points) : byBands(rule, bands, points);
  };

  // ---- one criterion over all points ---------------------------------------------------------------------------------
  const assess = (criterion, { size, completed, known, values }) => {
    const ok = new Uint8Array(size), margins = new Float64Array(size), chance = new Float64Array(size);
    for (let i = 0; i < size; i++) {
      const value = completed[i] ? values[i] : NaN;
      // The counts of a case do not depend on what happens in another one; the risks are those of points that came to their end.
      ok[i] = known[i] && within(criterion, values[i]) >= 0 ? 1 : 0;
      margins[i] = margin(criterion, value);
      if (criterion.uncertainty && completed[i]) chance[i] = chanceOf(criterion, value);
    }
    return { ok, margins, chance };
  };
  // While one criterion changes, the others keep what was found for them.
  const assessed = (criterion, points, k) => {
    const { nominal, uncertainty } = criterion;
    const key = JSON.stringify([nominal, reach(criterion), uncertainty]), cache = points.cache ??= [];
    if (cache[k]?.key !== key) cache[k] = { key, found: assess(criterion, { ...points, known: points.known[k], values: points.values[k] }) };
    return cache[k].found;
  };

  // ---- all criteria over all points --------------------------------------------------------------------------------------
  // The least margins and the joint conformance probabilities, where these are known.
  const together = (criteria, blocks, own, { size, completed, values }) => {
    const margins = new Float64Array(size).fill(Infinity), probability = new Float64Array(size);
    for (const { margins: each } of own) for (let i = 0; i < size; i++) margins[i] = Math.min(margins[i], each[i]);
    if (!blocks) return { margins, probability: null };
    const single = blocks.every(block => block.length === 1), lower = [], upper = [];
    for (let i = 0; i < size; i++) {
      if (!completed[i]) continue;
      if (single) probability[i] = own.reduce((product, { chance }) => product * chance[i], 1);
      else {
        criteria.forEach((c, k) => { [lower[k], upper[k]] = limits(c, values[k][i]); });
        probability[i] = joint(blocks, lower, upper);
      }
    }
    return { margins, probability };
  };
  const countBy = (samples, size, holds) => {
    const count = Array(samples).fill(0);
    for (let i = 0; i < size; i++) if (holds(i)) count[i % samples]++;
    return count;
  };
  const tallied = (rule, margins, chance, { size, samples }) => {
    const acceptance = tally(samples, chance !== null);
    for (let i = 0; i < size; i++) add(acceptance, widest(rule, margins[i]), i % samples, 1 - (chance ? chance[i] : 0));
    return acceptance;
  };
  // The guard band in expanded uncertainties and the first step that it accepts; null where the points show of none that it limits
  // the risk as required.
  const guardBand = (rule, allowed, anyWithin) => {
    if (rule?.risk === undefined) return { band: rule?.band ?? 0, from: 0 };
    if (!anyWithin) return { band: 0, from: 0 };
    const step = allowed?.widest ?? null;
    return step === null ? { band: null, from: Infinity } : { band: step * STEP, from: step };
  };
  const sum = list => list.reduce((a, b) => a + b, 0);

  /** Which points count for each criterion: those of whose case all values are known. What fails in one case costs no other one. */
  const known = (cases, values) => {
    const finite = members => Uint8Array.from(values[0] ?? [], (_, i) => members.every(k => Number.isFinite(values[k][i])) ? 1 : 0);
    const of = [...new Set(cases)].map(name => [name, finite([...cases.keys()].filter(k => cases[k] === name))]);
    return cases.map(name => of.find(([own]) => own === name)[1]);
  };

  /** Judges all points by a setting. */
  const judge = ({ criteria, correlations, rule }, points) => {
    const { size, completed, samples, grid } = points;
    const share = list => ({ passed: sum(list), fraction: sum(list) / size, interval: grid ? null : Moments.ofCounts(list, size, LEVEL) });
    const certain = criteria.every(c => c.uncertainty), blocks = certain ? errors(criteria.length, correlations) : null;
    const own = criteria.map((c, k) => assessed(c, points, k)), { margins, probability } = together(criteria, blocks, own, points);
    const all = tallied(rule, margins, probability, points), within = countBy(samples, size, i => margins[i] >= 0);
    const anyWithin = sum(within) > 0, limiting = rule?.risk !== undefined;
    const allowed = limiting && all.known && anyWithin ? allowedBands(all, criteria, rule.risk, rule.confidence, grid) : null;
    const { band, from } = guardBand(rule, allowed, anyWithin);
    const acceptedBySample = counts(split(all, from).accepted), accepted = sum(acceptedBySample);
    const possible = limiting || criteria.every(c => band === 0 || inUncertainties(c, half(c)) > band);
    const cannot = limiting ? anyWithin && (!all.known || leastRisk(all) > rule.risk) : anyWithin && accepted === 0 && !possible;
    const one = { least: acceptedBySample, most: acceptedBySample };
    const bands = allowed ?? one;
    // Where the joint probabilities are not known, the guard band is not known either.
    const unknown = limiting && !all.known && anyWithin, sure = unknown ? sureStep(criteria, rule.risk) : 0;
    const bounds = unknown && { least: countBy(samples, size, i => widest(rule, margins[i]) >= sure), most: within };
    const failed = size - sum(completed), result = failed < size;
    const groups = [...new Set(criteria.map(c => c.group).filter(Boolean))].map(name => {
      const members = own.filter((_, k) => criteria[k].group === name);
      return { name, ...share(countBy(samples, size, i => members.every(({ ok }) => ok[i]))) };
    });
    return {
      points: size,
      failed,
      // Where all points failed, nothing was compared.
      // Nor do points decide on a share whose error nothing tells.
      ...(!result || grid && rule ? { verdict: "inconclusive", interval: null }
        : unknown ? undecided(byBands(rule, bounds, size)) : conclude(rule, bands, accepted, within, size, cannot)),
      cannot,
      verified: share(countBy(samples, size, i => own.every(({ ok }) => ok[i]))),
      accepted,
      acceptedShare: share(acceptedBySample),
      guard_band: band,
      criteria: own.map(({ ok, margins: each, chance }, k) => {
        const known = criteria[k].uncertainty && result;
        return {
          ...share(countBy(samples, size, i => ok[i])),
          risk: known ? risk(tallied(rule, each, chance, points), from, grid) : null,
          capability: capability(criteria[k]),
        };
      }),
      groups,
      risk: result ? risk(all, from, grid) : null,
      expected_verified: probability && result ? sum(probability) : null,
      jointKnown: !certain || blocks !== null,
      flags: { ok: own.map(({ ok }) => ok), margins, probability, accepted: Uint8Array.from(margins, m => band !== null && widest(rule, m) >= from ? 1 : 0) },
    };
  };

  return { judge, known, margin, within, ends, reach, widest, sureStep, STEP };
})();
