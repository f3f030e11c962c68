"""The posterior of `identify` against emcee and against the exact one, with the model's runs and with a budget of some."""

import emcee
import numpy as np
import pytest
from functions import pack

from fmu_orchestrator import Study

LOW, HIGH, VALUE, ACCURACY = 0.5, 2.0, 1.0, 0.1
VALLEY = f"""fmu = "functions.fmu"
[identify.free.x1]
min = {LOW}
max = {HIGH}
[identify.free.x2]
min = {LOW}
max = {HIGH}
[identify.measured.P]
variable = "product"
value = {VALUE}
accuracy = {ACCURACY}
"""
WAVE = """fmu = "functions.fmu"
[identify.free.x1]
min = 0.1
max = 3.1
[identify.measured.W]
variable = "wave"
value = 0.5
accuracy = 0.02
"""
LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("posterior")
    pack(folder, 2, "product", "wave")
    (folder / "valley.toml").write_text(VALLEY)
    (folder / "wave.toml").write_text(WAVE)
    return folder


def sampled(folder, name, **options):
    """The outcome of `identify`, and its particles."""
    study = Study.load(folder / f"{name}.toml")
    output = folder / "-".join([name, *map(str, options.values())])
    # The functions spoil nothing: a process for each of thousands of runs would take ten times as long as all the rest.
    outcome = study.identify(output=output, progress=False, isolation="none", **options).data
    rows = np.loadtxt(output / "posterior.csv", delimiter=",", skiprows=2)
    return outcome, rows[:, 1:-1]


def log_density(x):
    inside = np.all((x >= LOW) & (x <= HIGH), axis=1)
    return np.where(inside, -0.5 * ((x.prod(axis=1) - VALUE) / ACCURACY) ** 2, -np.inf)


@pytest.fixture(scope="module")
def theirs():
    """emcee: 64 walkers and 6,000 steps, of which the first 1,000 do not count."""
    random = np.random.default_rng(1)
    np.random.seed(1)
    sampler = emcee.EnsembleSampler(64, 2, log_density, vectorize=True)
    sampler.run_mcmc(random.uniform(LOW, HIGH, (64, 2)), 6000)
    # It raises an error where the chain is too short for that; 64 chains of 5,000 are worth more than 3,000 draws.
    assert sampler.get_autocorr_time().max() < 100
    return sampler.get_chain(discard=1000, thin=40, flat=True)


def exact(grid=1500):
    """Places and density on a fine grid."""
    places = LOW + (HIGH - LOW) * (np.arange(grid) + 0.5) / grid
    one, other = np.meshgrid(places, places, indexing="ij")
    density = np.exp(-0.5 * ((one * other - VALUE) / ACCURACY) ** 2)
    return places, density / density.sum()


@pytest.mark.parametrize("runs", [None, 60])
def test_the_sample_is_the_posterior_and_that_of_emcee(folder, theirs, runs):
    outcome, ours = sampled(folder, "valley", posterior=2000, budget=runs)
    worth = outcome["posterior"]["effective"]
    assert worth > 400
    places, density = exact()
    for k in (0, 1):
        of_level = np.interp(LEVELS, density.sum(axis=1 - k).cumsum(), places)
        for level, place in zip(LEVELS, of_level, strict=True):
            # Four standard deviations of a share of so many draws.
            room = 4 * np.sqrt(level * (1 - level))
            assert abs(np.mean(ours[:, k] < place) - level) < room / np.sqrt(worth)
            assert abs(np.mean(theirs[:, k] < place) - level) < room / np.sqrt(3000)
    product = places[:, None] * places[None, :]
    mean = (product * density).sum()
    spread = np.sqrt(((product - mean) ** 2 * density).sum())
    assert abs(ours.prod(axis=1).mean() - mean) < 4 * spread / np.sqrt(worth)
    assert abs(ours.prod(axis=1).std() / spread - 1) < 4 / np.sqrt(2 * worth)
    assert abs(np.corrcoef(ours.T)[0, 1] - np.corrcoef(theirs.T)[0, 1]) < 0.06


def test_a_budget_is_kept_and_the_surrogate_says_how_it_errs(folder):
    outcome, _ = sampled(folder, "valley", posterior=2000, budget=60)
    told = outcome["surrogate"]
    assert told["runs"] <= 55 and told["checked"] > 0 and told["holds"]
    assert told["worst"]["counted"] < 0.05 * ACCURACY
    [again] = told["optima"][:1]
    assert abs(again["model"] - again["surrogate"]) < 0.01


@pytest.mark.long
def test_six_modes_have_their_parts(folder):
    outcome, ours = sampled(folder, "wave", posterior=2000)
    places = 0.1 + 3.0 * (np.arange(300000) + 0.5) / 300000
    density = np.exp(-0.5 * ((np.sin(6 * places) + 0.3 * places - 0.5) / 0.02) ** 2)
    between = [0.1, 0.77, 1.32, 1.82, 2.37, 2.87, 3.1]
    exact, _ = np.histogram(places, between, weights=density / density.sum())
    found, _ = np.histogram(ours[:, 0], between)
    errors = 4 * np.sqrt(exact * (1 - exact) / outcome["posterior"]["effective"])
    assert np.all(np.abs(found / len(ours) - exact) < errors), (found, exact)
