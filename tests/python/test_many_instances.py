"""Many instances at once: none knows of the others, and their memory comes back."""

import ctypes
import gc
from concurrent.futures import ThreadPoolExecutor

import pytest
from conftest import FMU2Stand

INSTANCES, KINDS, STEPS, STEP, THREADS = 100, 8, 5, 0.01, 8
OUTPUTS = ["sensor.loadForce", "sensor.frictionTorque", "sensor.bearingTemperature",
           "bearing.eccentricityRatio", "bearing.maxFilmPressure", "drive.angle"]


@pytest.fixture
def make(unpacked, description):
    """Makes the i-th instance: eight kinds, so that mixed-up instances would be noticed."""
    def new(i):
        kind = i % KINDS
        return FMU2Stand(unpacked, description).start(
            bearing__radialClearance=(15 + kind) * 1e-6, load__preload=40.0 + kind)
    return new


@pytest.fixture
def alone(make):
    """The outputs of each kind after every step, from an instance that is alone."""
    found = []
    for kind in range(KINDS):
        instance = make(kind)
        found.append([advanced(instance, i) for i in range(STEPS)])
        instance.freeInstance()
    return found


def advanced(instance, i):
    instance.doStep(i * STEP, STEP)
    return instance.get(*OUTPUTS)


def test_stepped_in_turn(make, alone):
    instances = [make(i) for i in range(INSTANCES)]
    for step in range(STEPS):
        for i, instance in enumerate(instances):
            assert advanced(instance, step) == alone[i % KINDS][step], i
    for instance in instances:
        instance.freeInstance()


def test_stepped_from_many_threads(make, alone):
    """Each thread has its own instances (ctypes lets the threads run at once)."""
    def part(first):
        instances = {i: make(i) for i in range(first, INSTANCES, THREADS)}
        for step in range(STEPS):
            for i, instance in instances.items():
                assert advanced(instance, step) == alone[i % KINDS][step], i
        for instance in instances.values():
            instance.freeInstance()
        return len(instances)

    with ThreadPoolExecutor(THREADS) as threads:
        assert sum(threads.map(part, range(THREADS))) == INSTANCES


def test_an_instance_goes_from_thread_to_thread(make, alone):
    with ThreadPoolExecutor(THREADS) as threads:
        instance = threads.submit(make, 3).result()
        for step in range(STEPS):
            assert threads.submit(advanced, instance, step).result() == alone[3][step]
        threads.submit(instance.freeInstance).result()


def resident():
    """Memory in use, bytes; what the allocator keeps for later is given back first."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    with open("/proc/self/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * 4096


def test_memory_comes_back(make):
    def cycle():
        instances = [make(i) for i in range(INSTANCES)]
        states = []
        for instance in instances:
            advanced(instance, 0)
            states.append(instance.getFMUstate())
        most = resident()
        for instance, state in zip(instances, states):
            instance.freeFMUstate(state)
            instance.freeInstance()
        return most

    cycle()
    before = resident()
    most = cycle()
    after = resident()
    print(f"before {before / 1e6:.1f} MB, most {most / 1e6:.1f} MB, after {after / 1e6:.1f} MB")
    assert most - before > 1000 * INSTANCES, "the instances need no memory?"
    assert after - before < 0.1 * (most - before)
