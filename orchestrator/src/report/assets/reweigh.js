"use strict";
// The judgement under other distributions of the parameters, from the points as they are, by weights. Where a fresh study of the
// changed distributions might come to either verdict, this says "not decided".
const Reweigh = (() => {
  const LEVEL = 0.95;
  const decide = (share, [low, high]) => low >= share ? "verified" : high < share ? "not verified" : "not decided";

  // The least band that limits the weighted risk as required; null where none does.
  const band = (steps, chance, weights, limit) => {
    const order = Array.from(steps.keys()).filter(i => steps[i] >= 0).sort((a, b) => steps[b] - steps[a]);
    let weight = 0, wrong = 0, least = null;
    order.forEach((i, k) => {
      weight += weights[i];
      wrong += weights[i] * (1 - chance[i]);
      const next = k + 1 < order.length ? steps[order[k + 1]] : -1;
      if (next < steps[i] && wrong <= limit * weight) least = next + 1;
    });
    return least;
  };

  // One point of a fresh study is enough: how probable is one among so many independent points?
  const byOnePoint = (interval, total) => {
    const some = interval.map(share => -Math.expm1(total * Math.log1p(-share)));
    return { verdict: some[0] >= LEVEL ? "verified" : some[1] <= 1 - LEVEL ? "not verified" : "not decided", some };
  };

  // A limited risk has a guard band of its own in the changed study. Whatever it is, it accepts no more points than the
  // tolerances, and no fewer than the band that is enough for any distribution.
  const byRisk = (setting, margins, chance, weights) => {
    const { rule, criteria } = setting, steps = margins.map(m => Judge.widest(rule, m)), sure = Judge.sureStep(criteria, rule.risk);
    const share = from => Weights.interval(weights, steps.map(step => step >= from ? 1 : 0), rule.confidence);
    const interval = [share(sure)[0], share(0)[1]], step = chance ? band(steps, chance, weights, rule.risk) : null;
    return {
      verdict: decide(rule.share, interval), interval,
      guard_band: step === null ? null : step * Judge.STEP,
      accepted: Uint8Array.from(steps, own => step !== null && own >= step ? 1 : 0),
    };
  };
  // No value lies within the tolerances less the guard band.
  const byNone = (rule, within, weights) => {
    const interval = Weights.interval(weights, within, rule.confidence), verdict = decide(rule.share, interval);
    return verdict === "not verified" ? { verdict, interval: [0, interval[1]] } : { verdict: "not decided", interval: null };
  };

  const conclude = (setting, result, weights, total) => {
    const { rule } = setting, { accepted, margins, probability } = result.flags;
    if (!rule) return byOnePoint(Weights.interval(weights, accepted, LEVEL), total);
    if (rule.risk !== undefined) return byRisk(setting, margins, probability, weights);
    if (result.cannot) return byNone(rule, Uint8Array.from(margins, m => m >= 0 ? 1 : 0), weights);
    const interval = Weights.interval(weights, accepted, rule.confidence);
    return { verdict: decide(rule.share, interval), interval };
  };

  /** What `result`, the judgement of the points as they are, becomes by weights; a fresh study would have `total` points. */
  const judge = (setting, points, result, weights, total) => {
    const { ok, probability } = result.flags, effective = Weights.effective(weights);
    const concluded = result.failed === result.points ? {} : conclude(setting, result, weights, total);
    const accepted = concluded.accepted ?? result.flags.accepted;
    const share = flags => ({ fraction: Weights.mean(weights, i => flags[i]), interval: Weights.interval(weights, flags, LEVEL) });
    const risk = chance => chance && {
      consumer: Weights.mean(weights, i => accepted[i] * (1 - chance[i])),
      producer: Weights.mean(weights, i => (1 - accepted[i]) * chance[i]),
      conformance_probability: Weights.mean(weights, i => chance[i]),
      not_conforming_given_accepted: Weights.mean(weights, i => 1 - chance[i], accepted),
    };
    const all = Uint8Array.from({ length: points.size }, (_, i) => ok.every(flags => flags[i]) ? 1 : 0);
    return {
      ...result, ...concluded, effective,
      flags: { ...result.flags, accepted },
      accepted: accepted.reduce((sum, is) => sum + is, 0),
      verified: { ...result.verified, ...share(all) },
      acceptedShare: { ...result.acceptedShare, ...share(accepted) },
      criteria: result.criteria.map((c, k) => ({ ...c, ...share(ok[k]), risk: null })),
      groups: [],
      risk: risk(probability),
      expected_verified: null,
    };
  };

  return { judge };
})();
