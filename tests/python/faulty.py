"""The FMUs of tests/faulty: what each does to a study, and how it is built."""

import subprocess
import threading
import zipfile
from dataclasses import dataclass

from test_acceptance import ROOT

SOURCES = ROOT / "tests" / "faulty"
OK = "ok"
# How the status of a point begins whose end depends on what is noticed first.
ANY = (OK, "crashed", "exited", "timeout", "out of memory", "fmi2Error", "fmi2Discard", "fmi2Fatal")


@dataclass(frozen=True)
class Model:
    """A behaviour, and what `verify` makes of it."""
    name: str
    hit: tuple = (OK,)  # how the status of a point with the fault may begin
    words: str = ""  # what it says, too
    waits: bool = False  # some points end by --point-timeout only
    options: tuple = ()  # of `verify`
    reproducible: bool = True  # whether fresh processes give the same results
    results: str = "healthy"  # of a point with the fault that is ok: as without it, its "own", or "any"
    attributes: str = ""  # of the element CoSimulation
    outputs: bool = True
    changes: str | tuple[str, ...] | None = None  # the first file that it changes in its own folder, or those that may be
    said: str = ""  # what a user of `verify` reads somewhere


def failing(name, *status, **more):
    return Model(name, status, **more)


def waiting(name, *status, **more):
    return Model(name, status or ("timeout",), waits=True, **more)


def any_end(name, **more):
    return Model(name, ANY, **more)


def changing(name, file, status=(OK,)):
    return Model(name, status, changes=file)


HEALTHY = Model("healthy")
# Of this model; a test can hold its points half-way (tests/faulty/model.c).
STUDY = """
fmu = "{fmu}"
[design]
method = "sobol"
points = 40
[parameters.rate]
distribution = "uniform"
min = 0.5
max = 2
[criteria.y]
variable = "y"
nominal = 0.6
tolerance = "50 %"
"""

MEMORY = [
    Model("drifts"),
    Model("drifts_later"),
    Model("spoils_later_points"),
    Model("resets_badly"),
    Model("draws_random_numbers", results="own"),
    Model("reads_unwritten_memory", reproducible=False),
    Model("reads_unwritten_memory_at_times", reproducible=None),
    Model("leaks_memory", options=("--memory-limit", "400MB")),
    failing("takes_much_memory", "out of memory", options=("--memory-limit", "100MB")),
    any_end("overruns_memory", waits=True, results="any"),
    failing("overflows_its_stack", "crashed"),
    Model("frees_twice"),
    failing("writes_to_null", "crashed", words="SIGSEGV"),
]
LIFE = [
    HEALTHY,
    Model("crashes_in_second_terminate"),
    Model("crashes_in_second_instantiate"),
    Model("allows_one_instance"),
    Model("allows_one_instance_ever"),
    Model("crashes_in_reset"),
    Model("crashes_in_free", said="sigsegv (fmi2terminate or fmi2freeinstance)"),
    waiting("loops_in_step"),
    waiting("loops_in_reset", OK),
    waiting("loops_in_terminate", OK, said="not done after 2 s (fmi2terminate or fmi2freeinstance)"),
    waiting("loops_in_free", OK, said="not done after 2 s (fmi2terminate or fmi2freeinstance)"),
    waiting("fails_and_loops_in_free", "fmi2Error"),
    waiting("loops_in_second_instantiate", OK),
    Model("fails_to_terminate", said="fmi2terminate"),
    Model("ends_early", results="own", said="ended at 0.5 s"),
    Model("warns", said="the oil is warm"),
    Model("says_version_one", said='fmi2getversion returns "1.0"'),
    Model("needs_a_tool", attributes='needsExecutionTool="true"', said="needsexecutiontool"),
    Model("has_no_outputs", outputs=False),
    failing("discards", "fmi2Discard"),
    failing("fails", "fmi2Error", words="the spring broke"),
    failing("fails_with_a_huge_message", "fmi2Error"),
    failing("dies", "fmi2Fatal", words="beyond repair"),
    failing("returns_a_wild_status", "fmi2Error", "unknown status", words="42"),
    failing("returns_a_negative_status", "fmi2Error", "unknown status", words="-7"),
    Model("is_pending", attributes='canRunAsynchronuously="true"'),
    waiting("is_pending_for_ever", "timeout", "fmi2Pending", attributes='canRunAsynchronuously="true"'),
    failing("gives_not_a_number", "not finite"),
    failing("gives_infinity", "not finite"),
]
LOGGER = [Model(name) for name in [
    "logs_to_environment_one", "logs_to_environment_two", "logs_to_itself", "logs_to_null", "logs_nothing_but_null",
    "logs_wild_statuses", "logs_percent_signs", "logs_from_threads", "logs_after_free", "passes_a_limit",
    "passes_limits_all_the_time"]]
PROCESSES = [
    any_end("forks_and_returns", waits=True),
    Model("starts_a_daemon"),
    Model("starts_children"),
    Model("leaves_threads_behind"),
    failing("becomes_another_program", "exited", "crashed"),
    waiting("becomes_a_sleeping_program", "timeout", "crashed"),
    waiting("ends_its_thread", "timeout", "exited", "crashed"),
    failing("exits", "exited"),
    failing("exits_at_once", "exited"),
    failing("exits_in_terminate", OK, "exited"),
    failing("aborts", "crashed", words="SIGABRT: faulty: assertion `gap > 0' failed"),
    failing("throws", "crashed", words="SIGABRT"),
    failing("jumps_out", "crashed", words="SIGABRT"),
    any_end("kills_its_parent"),
    any_end("terminates_its_parent"),
    any_end("interrupts_its_parent"),
    any_end("stops_its_parent", waits=True),
    any_end("kills_its_group"),
]
SIGNALS = [
    waiting("blocks_signals"),
    waiting("stops_itself", "timeout", "crashed"),
    waiting("handles_its_crash", "timeout", "crashed"),
    Model("ignores_signals"),
    failing("sets_an_alarm", OK, "crashed"),
    failing("divides_by_zero", "crashed", words="SIGFPE"),
    waiting("refuses_to_die_with_its_parent"),
]
DESCRIPTORS = [
    any_end("writes_stray_bytes", waits=True),
    any_end("writes_stray_lengths", waits=True),
    any_end("closes_descriptors", waits=True),
    any_end("closes_standard_streams", waits=True),
    any_end("replaces_descriptors", waits=True),
    Model("leaks_descriptors"),
    Model("reads_standard_input"),
    Model("talks_a_lot"),
    Model("talks_without_an_end"),
]
SURROUNDINGS = [
    Model("changes_surroundings"),
    Model("changes_floating_point", results="own"),
    any_end("sets_limits", waits=True),
    waiting("gives_up_system_calls", "crashed", "timeout", "exited"),
    Model("reads_the_clock", reproducible=False),
    Model("reads_its_process_number", reproducible=False),
    Model("reads_an_address", reproducible=False),
    Model("draws_truly_random_numbers", reproducible=False),
    Model("seeds_while_loaded", reproducible=False),
    Model("counts_in_a_file", reproducible=False),
    Model("gets_its_licence_later", attributes='needsExecutionTool="true"'),
    Model("shares_a_licence", attributes='needsExecutionTool="true"'),
]
FILES = [
    changing("leaves_a_file_in_its_resources", "resources/state.txt"),
    changing("leaves_a_file_at_its_end", "resources/state.txt"),
    changing("keeps_a_log_in_its_resources", "resources/log.txt"),
    changing("maps_a_file_of_its_resources", "resources/number.txt"),
    changing("removes_a_file_of_its_resources", "resources/number.txt"),
    # Which of the two names is seen hangs on the moment of the look.
    changing("replaces_a_file_of_its_resources", ("resources/number.txt", "resources/new.txt")),
    changing("removes_its_own_folder", ""),
    changing("cuts_its_own_binary", "binaries/linux64/faulty.so", status=(OK, "crashed")),
    Model("opens_its_resources_for_writing"),
    Model("leaves_a_file_in_its_working_directory"),
    Model("takes_its_time_to_end"),
]
LOADING = [
    Model("talks_while_loaded"),
    waiting("needs_the_thread_of_its_loading", OK),
    Model("reads_the_file_of_its_loading"),
    Model("knows_the_process_of_its_loading"),
    Model("crashes_at_exit"),
    Model("crashes_when_unloaded"),
    Model("loops_when_unloaded"),
    Model("crashes_with_its_thread"),
]
MODELS = MEMORY + LIFE + LOGGER + PROCESSES + SIGNALS + DESCRIPTORS + SURROUNDINGS + FILES + LOADING
# What no process keeps apart; of these a point may be wrong, and must be told of: scripts/evidence/alone.
MEETINGS = [Model(name, reproducible=None) for name in [
    "waits_at_a_port", "waits_for_datagrams", "names_a_socket", "locks_a_file_elsewhere", "locks_a_record_elsewhere",
    "locks_its_resources", "leaves_a_file_elsewhere", "reads_its_path"]]
# The name under which model.c knows the behaviour; the linker gives it to one of them, so that nothing is compiled for one model alone.
CHOSEN = "chosen_behaviour"
# Models without a function of their own in tests/faulty.
PLAIN = {"needs_a_tool", "has_no_outputs"}

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="faulty" guid="faulty">
  <CoSimulation modelIdentifier="faulty" canHandleVariableCommunicationStepSize="true" {attributes}/>
  <LogCategories><Category name="status"/><Category name="validity"/></LogCategories>
  <DefaultExperiment startTime="0" stopTime="1" stepSize="0.05"/>
  <ModelVariables>
    <ScalarVariable name="rate" valueReference="0" causality="parameter" variability="fixed"><Real start="1"/></ScalarVariable>
    <ScalarVariable name="fault" valueReference="1" causality="parameter" variability="fixed"><Integer start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="2" causality="{causality}"><Real/></ScalarVariable>
    <ScalarVariable name="sum" valueReference="3" causality="{causality}"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>{structure}</ModelStructure>
</fmiModelDescription>
"""
UNKNOWNS = '<Unknown index="3"/><Unknown index="4"/>'
STRUCTURE = f"<Outputs>{UNKNOWNS}</Outputs><InitialUnknowns>{UNKNOWNS}</InitialUnknowns>"


def description(attributes="", outputs=True):
    return DESCRIPTION.format(attributes=attributes, causality="output" if outputs else "local",
                              structure=STRUCTURE if outputs else "")


class Workshop:
    """Builds the FMUs. What does not depend on the behaviour is compiled once."""

    FLAGS = ["-O1", "-fPIC", "-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter", "-Wno-infinite-recursion",
             "-D_FORTIFY_SOURCE=2", "-fvisibility=default"]

    def __init__(self, folder):
        self.folder, self.lock, self.objects = folder, threading.Lock(), None

    def compile(self, *arguments):
        subprocess.run(["cc", *self.FLAGS, *map(str, arguments)], check=True)

    def compiled(self, source, *flags):
        into = self.folder / f"{source.stem}{'-'.join(flags)}.o"
        self.compile("-c", source, *flags, "-o", into)
        return into

    def parts(self):
        with self.lock:
            if self.objects is None:
                self.objects = {source.stem: self.compiled(source, f"-DBEHAVIOUR={CHOSEN}") for source in sorted(SOURCES.glob("*.c"))}
        return self.objects

    def binary(self, behaviour, flags=(), missing=False):
        """The binary of a behaviour; with `missing`, one whose code calls a function that no library defines."""
        objects = dict(self.parts())
        if missing:
            objects["loading"] = self.compiled(SOURCES / "loading.c", "-DMISSING")
        into = self.folder / f"{behaviour}-{len(flags)}{missing}.so"
        # Several models have the same behaviour, and are built at the same time: a file is there as a whole or not.
        under_way = self.folder / f"{into.name}.{threading.get_ident()}"
        if flags:
            objects["model"] = SOURCES / "model.c"
        self.compile("-shared", "-Wl,-Bsymbolic", f"-Wl,--defsym={CHOSEN}={behaviour}", f"-DBEHAVIOUR={CHOSEN}", *objects.values(),
                     *flags, "-o", under_way, "-lm", "-lpthread")
        return under_way.replace(into)

    def fmu(self, name, binary, text=None):
        into = self.folder / f"{name}.fmu"
        with zipfile.ZipFile(into, "w") as archive:
            archive.writestr("modelDescription.xml", text or description())
            archive.write(binary, "binaries/linux64/faulty.so")
            archive.writestr("resources/number.txt", "0\n")
        return into

    def study(self, file):
        """Writes a study of 40 points of the healthy model."""
        file.write_text(STUDY.format(fmu=self.model(HEALTHY)))

    def model(self, model):
        behaviour = "healthy" if model.name in PLAIN else model.name
        return self.fmu(model.name, self.binary(behaviour), description(model.attributes, model.outputs))
