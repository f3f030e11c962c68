"""Whatever an FMU does, it costs its own points only; all others get what they get alone in a fresh process."""

import signal

import faulty
import pytest
from faulty import MODELS
from laboratory import NO_TIMEOUT, OUTPUTS, POINTS, TIMEOUT, Laboratory, bits, complaints, rate, study
from test_acceptance import orchestrator

BY_NAME = {model.name: model for model in MODELS}
# For the long run: each has a sibling that does the same another way.
SELDOM = {
    "drifts_later", "spoils_later_points", "reads_unwritten_memory_at_times", "crashes_in_second_instantiate", "allows_one_instance",
    "crashes_in_reset", "loops_in_free", "loops_in_second_instantiate", "returns_a_negative_status", "gives_infinity",
    "logs_to_environment_two", "logs_to_itself", "logs_nothing_but_null", "logs_wild_statuses", "exits_at_once", "throws", "jumps_out",
    "interrupts_its_parent", "divides_by_zero", "writes_stray_lengths", "closes_standard_streams", "talks_without_an_end",
    "reads_its_process_number", "reads_an_address", "draws_truly_random_numbers"}
# A run of these is killed and resumed in every run of the tests: they leave processes, files or locks behind, stay in the way of
# signals, or give each status that a journal can hold, and all that a summary counts.
KILLED = {
    "healthy", "draws_random_numbers", "takes_much_memory", "writes_to_null", "crashes_in_free", "fails_to_terminate",
    "ends_early", "discards", "fails", "dies", "gives_not_a_number", "is_pending", "has_no_outputs", "warns", "passes_a_limit",
    "forks_and_returns", "starts_a_daemon", "starts_children", "leaves_threads_behind", "becomes_a_sleeping_program", "exits",
    "exits_in_terminate", "aborts", "kills_its_parent", "stops_its_parent", "kills_its_group", "blocks_signals", "stops_itself",
    "ignores_signals", "refuses_to_die_with_its_parent", "writes_stray_bytes", "closes_descriptors", "leaks_descriptors",
    "changes_surroundings", "sets_limits", "reads_the_clock", "counts_in_a_file", "gets_its_licence_later",
    "shares_a_licence", "takes_its_time_to_end", "crashes_at_exit", "loops_when_unloaded"}


def every(models, ordinary):
    marked = [model if ordinary(model.name) else pytest.param(model, marks=pytest.mark.long) for model in models]
    return pytest.mark.parametrize("model", marked, ids=lambda model: model.name)


every_model = every(MODELS, lambda name: name not in SELDOM)
every_killed_model = every(MODELS, lambda name: name in KILLED)


def models(*names):
    return pytest.mark.parametrize("model", [BY_NAME[name] for name in names], ids=lambda model: model.name)


@pytest.fixture(scope="module")
def laboratory(request, tmp_path_factory):
    laboratory = Laboratory(tmp_path_factory.mktemp("faulty"))

    def asked(fixture):
        items = [item for item in request.session.items if fixture in getattr(item, "fixturenames", ())]
        return dict.fromkeys(item.callspec.params["model"].name for item in items)

    killed = asked("killed_case")
    laboratory.begin([(BY_NAME[name], name in killed) for name in asked("case")])
    yield laboratory
    laboratory.end()


@pytest.fixture
def case(laboratory, model):
    return laboratory.case(model)


@pytest.fixture
def killed_case(case):
    """With a run that was killed and resumed."""
    return case


@every_model
def test_all_other_points_are_right(case):
    assert complaints(case, case.whole) == []
    if case.model.said:
        assert case.model.said in case.whole.said.lower() + str(case.whole.summary).lower()


@pytest.mark.long
@every_model
def test_points_without_a_fault_are_those_of_the_healthy_model(case, laboratory):
    fmu = laboratory.workshop.folder / f"{case.model.name}.fmu"
    if case.model.reproducible and case.model.results != "own":
        assert laboratory.fresh(fmu) == laboratory.sound


@every_model
def test_no_process_is_left(case):
    assert case.whole.strays == []


@every_killed_model
def test_killed_and_resumed(killed_case):
    case = killed_case
    assert case.killed, "the kill came too late"
    assert complaints(case, case.resumed) == []


@every_killed_model
def test_no_process_outlives_a_killed_supervisor(killed_case):
    assert killed_case.strays == []
    assert killed_case.resumed.strays == []


@every_model
def test_the_summary_tells_what_the_results_are_worth(case):
    for outcome in case.outcomes:
        # What a few points do shows where one of them runs again.
        assert case.model.reproducible in (None, outcome.summary["reproducible"])
        assert outcome.summary["isolation"] == "fresh"
        if case.model.reproducible is False:
            assert "not reproducible" in outcome.said


def told(case, name):
    for outcome in (case.whole, case.resumed):
        yield outcome.summary[name]


@models("warns", "healthy", "logs_to_environment_one")
def test_warnings_are_counted(killed_case):
    case = killed_case
    warns = case.model.name == "warns"
    for warnings in told(case, "warnings"):
        assert (warnings["points"], warnings["count"]) == ((POINTS, 20 * POINTS) if warns else (0, 0))
        assert warnings["first"] == ({"point": 1, "message": "fmi2DoStep: the oil is warm"} if warns else None)


@models("passes_a_limit", "passes_limits_all_the_time", "healthy")
def test_points_beyond_the_model_are_counted_by_limit(killed_case):
    case = killed_case
    every = [("step -0.2 is beyond step 0", POINTS, 1), ("in a thread: step 0.5", POINTS, 1)]
    one = [(f"the rate {rate(9):.4f} is beyond its limit", len(case.hit), 9)]
    expected = {"passes_a_limit": one, "passes_limits_all_the_time": every}.get(case.model.name, [])
    for validity in told(case, "validity"):
        limits = [(limit["first"]["message"], limit["points"], limit["first"]["point"]) for limit in validity["limits"]]
        assert limits == expected
        points = max((points for _, points, _ in expected), default=0)
        assert (validity["points"], validity["verified"]) == (points, points)


@models("ends_early", "healthy")
def test_ends_that_the_fmu_chose_are_counted(killed_case):
    case = killed_case
    early = case.model.name == "ends_early"
    for ends in told(case, "ended_early"):
        assert ends["points"] == (len(case.hit) if early else 0)
        assert ends["first"] == ({"point": 9, "message": "ended at 0.5 s"} if early else None)


@models("fails_to_terminate", "crashes_in_free", "loops_in_terminate", "healthy")
def test_simulations_that_cannot_be_ended_are_counted(killed_case):
    case = killed_case
    points = {"healthy": 0, "loops_in_terminate": len(case.hit)}.get(case.model.name, POINTS)
    for errors in told(case, "terminate_errors"):
        assert errors["points"] == points
        assert "fmi2" in errors["first"]["message"] if points else errors["first"] is None


@models(*[model.name for model in MODELS if model.changes is not None], "opens_its_resources_for_writing", "healthy")
def test_the_first_file_that_an_fmu_changes_in_its_folder_is_named(killed_case):
    case = killed_case
    for outcome in (case.whole, case.resumed):
        file = outcome.summary["changed_file"]
        if case.model.changes is None:
            assert file is None
        else:
            assert file is not None and file.startswith(case.model.changes)
            assert f"the first: {file}" in outcome.said


@models("takes_its_time_to_end")
def test_an_fmu_has_the_time_of_a_point_to_end(case):
    assert case.whole.summary["terminate_errors"]["points"] == 0
    assert len((case.folder / "run-whole" / "ended").read_bytes()) >= len(case.hit)


@models("fails_to_terminate", "exits_in_terminate", "loops_in_terminate", "crashes_in_free")
def test_they_are_counted_in_shared_processes_too(case, laboratory, tmp_path):
    """A process that is lost in fmi2Terminate costs no result: the point runs again alone, and is counted there. An
    instance that is reset for the next point is not freed: only the points that ran alone tell of that."""
    fmu = laboratory.workshop.folder / f"{case.model.name}.fmu"
    options = ["--isolation", "shared", "--point-timeout", TIMEOUT if case.model.waits else NO_TIMEOUT]
    outcome = study(tmp_path, fmu, case.hit, options=options).run()
    assert complaints(case, outcome) == []
    fresh, points = case.whole.summary["terminate_errors"]["points"], outcome.summary["terminate_errors"]["points"]
    assert 0 < points < fresh if case.model.name == "crashes_in_free" else points == fresh


@models("says_version_one", "needs_a_tool", "healthy")
def test_what_concerns_the_whole_fmu_is_told_once(killed_case):
    case = killed_case
    version, tool = case.model.name == "says_version_one", case.model.name == "needs_a_tool"
    for outcome in (case.whole, case.resumed):
        assert outcome.summary["fmi_version"] == ("1.0" if version else None)
        assert outcome.summary["needs_execution_tool"] is tool
        assert outcome.said.count("fmi2GetVersion returns") == version


# Longer than the second that ending takes, much shorter than --point-timeout.
SOON = 30.0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=lambda number: number.name)
@models("loops_in_step", "blocks_signals", "stops_itself", "becomes_a_sleeping_program", "forks_and_returns",
        "starts_a_daemon", "closes_descriptors", "is_pending_for_ever")
def test_a_signal_ends_the_run(case, laboratory, tmp_path, number):
    """Points under way are given up; those that were done are kept."""
    fmu = laboratory.workshop.folder / f"{case.model.name}.fmu"
    run = study(tmp_path, fmu, case.hit, options=["--point-timeout", NO_TIMEOUT])
    (run.mark / "held").touch()
    code, running, strays = run.interrupted(5, number, deadline=SOON)
    assert running and code in (130, 143), f"{code} {strays}"
    assert strays == [] and run.progress() >= 5


@models("loops_in_step", "blocks_signals", "stops_itself")
def test_a_signal_ends_a_run_of_which_only_hanging_points_are_left(case, laboratory, tmp_path):
    fmu = laboratory.workshop.folder / f"{case.model.name}.fmu"
    run = study(tmp_path, fmu, {POINTS - 1, POINTS}, options=["--point-timeout", NO_TIMEOUT])
    code, running, strays = run.interrupted(POINTS - 2, signal.SIGTERM, deadline=SOON)
    assert running and code in (130, 143), f"{code} {strays}"
    assert strays == []


def unstartable(workshop, name):
    """FMUs whose binary cannot be loaded, with what the user has to read."""
    library = workshop.folder / "libfaultyhelper.so.3"
    if name == "a_missing_function_of_fmi":
        return workshop.binary("healthy", ["-Dfmi2DoStep=anotherName"]), ["fmi2DoStep"]
    if name.startswith("a_missing_library"):
        workshop.compile("-shared", f"-Wl,-soname,{library.name}", "-x", "c", "/dev/null", "-o", library)
        flags = ["-Wl,--no-as-needed", library] + (["-Dfmi2DoStep=anotherName"] if "function" in name else [])
        binary = workshop.binary("healthy", flags)
        library.unlink()
        return binary, [library.name]
    words = {"crashes_while_loaded": ["SIGSEGV"], "exits_while_loaded": ["code 0"], "loops_while_loaded": ["time"]}
    return workshop.binary(name), words[name]


@pytest.mark.parametrize("name", [
    "a_missing_function_of_fmi", "a_missing_library", "a_missing_library_and_function",
    "crashes_while_loaded", "exits_while_loaded", "loops_while_loaded"])
def test_what_cannot_be_loaded_is_said_at_once(laboratory, tmp_path, name):
    binary, words = unstartable(laboratory.workshop, name)
    fmu = laboratory.workshop.fmu(name, binary)
    outcome = study(tmp_path, fmu, (), options=["--point-timeout", "2"]).run()
    assert outcome.code == 2, outcome.said
    assert len(outcome.said.strip().splitlines()) == 1, outcome.said
    assert all(word in outcome.said for word in words), outcome.said
    assert outcome.strays == []


def test_a_function_that_no_library_has_is_named(laboratory, tmp_path):
    """Loaders resolve the missing function while loading or at its first call; most points never call it."""
    fmu = laboratory.workshop.fmu("missing", laboratory.workshop.binary("calls_a_missing_function", missing=True))
    outcome = study(tmp_path, fmu, {9}).run()
    assert "function_of_a_library" in outcome.said + str(outcome.points.get(9))
    assert outcome.code == 2 or [p for p, row in outcome.points.items() if row["status"] != "ok"] == [9], outcome.said


def test_an_fmu_of_which_no_instance_ever_comes(laboratory, tmp_path):
    """Either the run ends with the reason, or all points have it."""
    fmu = laboratory.workshop.fmu("no_instance", laboratory.workshop.binary("loops_in_instantiate"))
    outcome = study(tmp_path, fmu, (), options=["--point-timeout", "1"], points=4).run()
    assert outcome.code in (2, 3), outcome.said
    assert outcome.strays == []
    if outcome.code == 2:
        assert "fmi2Instantiate" in outcome.said or "time" in outcome.said
    else:
        assert [row["status"][:7] for row in outcome.points.values()] == ["timeout"] * 4


@pytest.mark.parametrize("attributes", ["", 'needsExecutionTool="true"'], ids=["slow", "tool"])
def test_what_starts_slowly_starts_once_in_shared_processes(laboratory, tmp_path, attributes):
    workshop = laboratory.workshop
    fmu = workshop.fmu("starts_slowly", workshop.binary("starts_slowly"), faulty.description(attributes))
    expected = laboratory.fresh(workshop.fmu("quick", workshop.binary("healthy")), points=30)
    run = study(tmp_path, fmu, (), options=["--isolation", "shared"], points=30)
    outcome = run.run()
    assert outcome.code == 0, outcome.said
    assert {point: bits(row) for point, row in outcome.points.items()} == expected
    assert len((run.mark / "starts").read_bytes()) < 15


def built(laboratory, name):
    return laboratory.workshop.model(BY_NAME[name])


@pytest.mark.parametrize("name", ["healthy", "has_no_outputs", "needs_a_tool", "ends_early", "is_pending",
                                  "leaves_threads_behind", "keeps_a_log_in_its_resources"])
def test_what_the_standard_allows_is_no_error(laboratory, name):
    assert "error" not in orchestrator("check", built(laboratory, name))


@pytest.mark.parametrize("name, word", [
    ("says_version_one", "1.0"), ("needs_a_tool", "needsExecutionTool"), ("warns", "warning"),
    ("keeps_a_log_in_its_resources", "resources/log.txt")])
def test_a_check_tells_what_to_beware_of(laboratory, name, word):
    assert word in orchestrator("check", built(laboratory, name))


# One instance in a process's whole life is no fault where the FMU declares it; this one does not.
@pytest.mark.parametrize("name, word", [
    ("fails_to_terminate", "fmi2Terminate"), ("reads_unwritten_memory", "memory"), ("drifts", "it must be as alone"),
    ("allows_one_instance_ever", "second instance")])
def test_a_check_finds_what_would_make_a_study_wrong(laboratory, name, word):
    errors = [line for line in orchestrator("check", built(laboratory, name), code=1).splitlines() if "error: " in line]
    assert any(word in line for line in errors)


def test_a_simulation_that_ends_early_is_whole(laboratory):
    fmu = built(laboratory, "ends_early")
    last = orchestrator("simulate", fmu, "--set", f"rate={rate(1)!r}", "--set", "fault=1").splitlines()[-1].split(",")
    assert float(last[0]) == 0.5
    assert [float(cell).hex() for cell in last[1:]] == laboratory.fresh(fmu, hit={1}, points=1)[1]


def test_an_fmu_without_outputs_is_simulated_with_its_locals(laboratory):
    lines = orchestrator("simulate", built(laboratory, "has_no_outputs")).splitlines()
    assert lines[0].split(",") == ["time", "y", "sum"] and len(lines) == 22
