"""Points of an FMU, each simulated by fmpy in a process of its own that has loaded the FMU and never instantiated it:
the reference for what the orchestrator computes, which shares nothing with it. Results are exact, as hex floats.

    python fresh_points.py JOB.json     prints a JSON list, an item a point: {"values": [...]} or {"failure": "..."}

A job holds fmu, points (a list of {name: value}), outputs, stop, step, and where they matter start, tolerance and
timeout; with own_folders each point has an unpacked FMU and a working directory of its own. With kind, `CoSimulation` or
`ModelExchange`, fmpy's `simulate_fmu` runs the points, those of FMI 3.0, too. Its point processes are new ones: slow (fmpy is imported each time), but nothing is older than the point.
`Server` forks them from a process that has imported fmpy and loaded no FMU: some milliseconds a point."""

import contextlib
import ctypes
import functools
import json
import math
import os
import select
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import fmpy
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

TIMEOUT = 60.0  # s
# When so many points, and no others, have come to the timeout, the rest is not waited for.
HOPELESS = 3
DISCARD, PENDING = 2, 5
PR_SET_PDEATHSIG = 1


def prepared(job, folder):
    """The job with what the FMU's description says, and the FMU unpacked."""
    description = fmpy.read_model_description(job["fmu"], validate=False)
    fmpy.extract(job["fmu"], folder)
    if "kind" in job:
        place = Path(folder, "at")
        place.mkdir()
        return {"timeout": TIMEOUT, **job, "folder": str(folder), "place": str(place)}
    if description.coSimulation is None:
        raise ValueError("no Co-Simulation")
    experiment = description.defaultExperiment
    tolerance = experiment.tolerance if experiment is not None else None
    return {"start": 0.0, "tolerance": None if tolerance is None else float(tolerance), "timeout": TIMEOUT, **job,
            "folder": str(folder), "guid": description.guid, "identifier": description.coSimulation.modelIdentifier,
            "variables": {v.name: (v.valueReference, v.type) for v in description.modelVariables}}


def communication_points(start, stop, step):
    """Multiples of the step from the start; the last one is the stop time, and no step is a rounding error."""
    steps = max(1, math.ceil((stop - start) / step - 1e-6))
    return [start + i * step for i in range(steps)] + [stop]


@functools.cache
def callbacks():
    """fmpy's callbacks without Python in them: memory from the C library, messages to nobody. They live as long as the
    process: a thread of an FMU may call them when its instance is gone."""
    library, types = ctypes.CDLL(None), fmi2
    made = types.fmi2CallbackFunctions()
    made.logger = ctypes.cast(library.getpid, types.fmi2CallbackLoggerTYPE)
    made.allocateMemory = ctypes.cast(library.calloc, types.fmi2CallbackAllocateMemoryTYPE)
    made.freeMemory = ctypes.cast(library.free, types.fmi2CallbackFreeMemoryTYPE)
    return made


def assign(slave, variable, value):
    """Sets a variable as the orchestrator's studies do: whole numbers rounded, true from 0.5 on."""
    reference, kind = variable
    if kind == "Real":
        slave.setReal([reference], [value])
    elif kind == "Boolean":
        slave.setBoolean([reference], [value >= 0.5])
    else:
        slave.setInteger([reference], [int(math.copysign(math.floor(abs(value) + 0.5), value))])


def read(slave, variable):
    reference, kind = variable
    get = {"Real": slave.getReal, "Boolean": slave.getBoolean}.get(kind, slave.getInteger)
    return float(get([reference])[0]).hex()


def advance(slave, now, step):
    """One step; whether the FMU wants further ones."""
    try:
        status = slave.fmi2DoStep(slave.component, now, step, fmi2.fmi2True)
    except FMICallException as error:
        status = error.status
    while status == PENDING:
        time.sleep(0.001)
        status = slave.getStatus(fmi2.fmi2DoStepStatus)
    if status == DISCARD and slave.getBooleanStatus(fmi2.fmi2Terminated):
        return False
    if status not in (fmi2.fmi2OK, fmi2.fmi2Warning):
        raise RuntimeError(f"fmi2DoStep: status {status}")
    return True


def simulate(job, values):
    """The outputs at the end of one simulation. The instance is left as it is: results come before its end."""
    # Known beforehand: the FMU may change how this process rounds.
    times = communication_points(job["start"], job["stop"], job["step"])
    steps = [(now, then - now) for now, then in zip(times, times[1:])]
    slave = fmi2.FMU2Slave(guid=job["guid"], unzipDirectory=job["folder"], modelIdentifier=job["identifier"],
                           instanceName="point")
    slave.instantiate(callbacks=callbacks())
    slave.setupExperiment(tolerance=job["tolerance"], startTime=job["start"], stopTime=job["stop"])
    for name, value in values.items():
        assign(slave, job["variables"][name], value)
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    for now, step in steps:
        if not advance(slave, now, step):
            break
    return [read(slave, job["variables"][name]) for name in job["outputs"]]


def simulated(job, values):
    """The outputs at the end, its time, and the largest magnitude of each on the way, by fmpy's own simulation."""
    description = fmpy.read_model_description(job["folder"], validate=False)
    more = {} if job["kind"] == "CoSimulation" else {"relative_tolerance": job["tolerance"], "record_events": False}
    rows = fmpy.simulate_fmu(job["folder"], validate=False, model_description=description, fmi_type=job["kind"],
                             start_time=job["start"], stop_time=job["stop"], output_interval=job["step"],
                             start_values=values, output=job["outputs"], **more)
    columns = [rows[name].astype(float).reshape(len(rows), -1).T for name in job["outputs"]]
    signals = [signal for column in columns for signal in column]
    return {"values": [float(signal[-1]).hex() for signal in signals], "time": float(rows["time"][-1]),
            "largest": [float(abs(signal).max()) for signal in signals]}


def answer(job, values, into):
    """Simulates in this process, which ends with it. What the FMU prints is thrown away."""
    into = os.dup(into)
    os.chdir(job.get("place", "."))
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nothing, stream)
    try:
        result = simulated(job, values) if "kind" in job else {"values": simulate(job, values)}
    except Exception as error:  # whatever it is, it is the point's
        result = {"failure": f"{type(error).__name__}: {error}"}
    os.write(into, json.dumps(result).encode() + b"\n")
    os._exit(0)


def result_of(process, pipe, timeout):
    """Waits for a point's line, and ends its process group."""
    end, text = time.monotonic() + timeout, b""
    while not text.endswith(b"\n"):
        ready, _, _ = select.select([pipe], [], [], max(0.0, end - time.monotonic()))
        part = os.read(pipe, 65536) if ready else b""
        if not part:
            break
        text += part
    try:
        os.killpg(process, signal.SIGKILL)
    except ProcessLookupError:
        pass
    if text.endswith(b"\n"):
        return json.loads(text)
    return {"failure": "the process ended" if time.monotonic() < end else "timeout"}


@contextlib.contextmanager
def apart(job):
    """The job with an unpacked FMU and an empty working directory that no other point sees, where it wants that."""
    if not job.get("own_folders"):
        yield job
        return
    with tempfile.TemporaryDirectory(prefix="fresh-point-", ignore_cleanup_errors=True) as folder:
        own, place = Path(folder, "fmu"), Path(folder, "at")
        place.mkdir()
        fmpy.extract(job["fmu"], own)
        yield {**job, "folder": str(own), "place": str(place)}


def forked(job, values):
    """A point in a fork of this process."""
    with apart(job) as job:
        return forked_there(job, values)


def forked_there(job, values):
    ours, theirs = os.pipe()
    process = os.fork()
    if process == 0:
        os.setsid()
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        answer(job, values, theirs)
    os.close(theirs)
    result = result_of(process, ours, job["timeout"])
    os.close(ours)
    os.waitpid(process, 0)
    return result


def started(job, values, environment=None):
    """A point in a new process."""
    command = [sys.executable, __file__, "--point"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
                               start_new_session=True, env={**os.environ, **(environment or {})})
    try:
        process.stdin.write(json.dumps([job, values]).encode())
        process.stdin.close()
        return result_of(process.pid, process.stdout.fileno(), job["timeout"])
    except BrokenPipeError:
        return {"failure": "the process ended"}
    finally:
        process.wait()
        process.stdout.close()


def run(job, way=started, workers=1, **options):
    """All points of a job."""
    folder = tempfile.mkdtemp(prefix="fresh-points-")
    try:
        job = prepared(job, folder)
        with ThreadPoolExecutor(workers) as threads:
            return list(threads.map(lambda values: way(job, values, **options), job["points"]))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class Server:
    """A process that has imported fmpy and forks a process a point."""

    def __init__(self, environment=None):
        self.process = subprocess.Popen([sys.executable, __file__, "--serve"], text=True, stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, env={**os.environ, **(environment or {})})

    def run(self, job):
        self.process.stdin.write(json.dumps(job) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def close(self):
        self.process.stdin.close()
        self.process.wait()
        self.process.stdout.close()


def serve():
    for line in sys.stdin:
        job = json.loads(line)
        folder = tempfile.mkdtemp(prefix="fresh-points-")
        try:
            job = prepared(job, folder)
            results = []
            for values in job["points"]:
                hopeless = len(results) >= HOPELESS and all(r == {"failure": "timeout"} for r in results)
                results.append(results[-1] if hopeless else forked(job, values))
        except Exception as error:  # such as a description that fmpy refuses
            results = [{"failure": f"{type(error).__name__}: {error}"}] * len(job["points"])
        finally:
            shutil.rmtree(folder, ignore_errors=True)
        print(json.dumps(results), flush=True)


def main():
    if sys.argv[1:] == ["--serve"]:
        serve()
    elif sys.argv[1:] == ["--point"]:
        job, values = json.load(sys.stdin)
        answer(job, values, 1)
    else:
        print(json.dumps(run(json.loads(Path(sys.argv[1]).read_text()))))


if __name__ == "__main__":
    main()
