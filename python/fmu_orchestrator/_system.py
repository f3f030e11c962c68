"""One FMU of a system of FMUs (SSP 1.0, 2.0), by the containers of fmu-manipulation-toolbox.

    python -m fmu_orchestrator system SYSTEM.ssp --step H --output S.fmu [--force]

A container's own step is fixed, and the step check has to halve it. So the FMUs stand in a container whose finest step is H / 4, and
its `container.ts_multiplier` says how many of these it takes at once; a container around it makes 4 the start value.
"""

import argparse
import importlib
import logging
import posixpath
import re
import sys
import tempfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path
from shutil import copyfile
from typing import Any
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree

from ._errors import OrchestratorError

# As the library names it, and its start value: it can be halved twice.
MULTIPLIER, MOST = "container.ts_multiplier", 4
# Times that differ by less are one time to the library.
SAME_TIME = 1e-8
PLATFORMS = {"linux": ("linux64", "x86_64-linux"), "win32": ("win64", "x86_64-windows"), "darwin": ("darwin64", "aarch64-darwin")}
# What the library leaves out of a variable's description.
LEFT_OUT = ("unit", "displayUnit", "quantity", "relativeQuantity", "min", "max", "nominal")
BASES = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
REALS = ("Real", "Float64", "Float32")
SAME = (1.0, 0.0)

Element = ElementTree.Element
Node = tuple[str, str]  # the path of a component or system, the name of a connector
Units = dict[str, Element]


@dataclass
class Component:
    """An FMU of the system."""

    file: str
    fmi: int
    variables: dict[str, dict[str, Any]]  # their attributes, `kind`, and the `items` of an enumeration
    units: Units


@dataclass
class Structure:
    """The system without its levels."""

    systems: set[str] = field(default_factory=set)
    components: dict[str, Component] = field(default_factory=dict)
    connectors: dict[Node, Element] = field(default_factory=dict)
    feeds: dict[Node, tuple[Node, bool]] = field(default_factory=dict)  # by their ends: the start, and whether units may differ
    values: dict[Node, tuple[str, str | None, Units]] = field(default_factory=dict)  # text, unit, and what units mean there
    unused: list[str] = field(default_factory=list)


def units_in(root: Element, where: str) -> Units:
    return {unit.attrib["name"]: unit for unit in root.iterfind(f"{where}/Unit")}


def meaning(name: str, units: Units) -> tuple[tuple[int, ...], float, float] | None:
    """Exponents, factor and offset of the base units; none where the unit is not defined."""
    base = units[name].find("BaseUnit") if name in units else None
    return None if base is None else (tuple(int(base.get(key, 0)) for key in BASES), float(base.get("factor", 1)), float(base.get("offset", 0)))


def conversion(given: str | None, units: Units, wanted: str | None, others: Units) -> tuple[float, float] | None:
    """Factor and offset from one unit to another; none where it is not known."""
    if not given or not wanted:
        return SAME
    first, second = meaning(given, units), meaning(wanted, others)
    if first is None or second is None:
        # Some write [m] for m.
        return SAME if given.strip("[]") == wanted.strip("[]") else None
    return (first[1] / second[1], (first[2] - second[2]) / second[1]) if first[0] == second[0] else None


class Reader:
    """Reads an SSP; its FMUs go into a folder."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path, self.folder, self.structure = path, folder, Structure()
        try:
            self.archive = zipfile.ZipFile(path)
        except OSError as error:
            raise OrchestratorError(f"{path}: {error.strerror or error}") from None
        except zipfile.BadZipFile:
            raise OrchestratorError(f"{path}: no SSP, which is a zip archive with SystemStructure.ssd") from None
        if "SystemStructure.ssd" not in self.archive.namelist():
            raise OrchestratorError(f"{path}: no SSP: it holds no SystemStructure.ssd; name the system's file")
        self.root = self.xml("SystemStructure.ssd")
        self.units = units_in(self.root, "Units")
        for system in self.root.iterfind("System"):
            self.system("", system)
        if not self.structure.components:
            raise self.error("SystemStructure.ssd", "there is no component")

    def error(self, where: str | Node, why: str) -> OrchestratorError:
        return OrchestratorError(f"{self.path}: {where if isinstance(where, str) else '.'.join(where).lstrip('.')}: {why}")

    def content(self, source: str, where: str) -> bytes:
        parts = urlsplit(source)
        try:
            if not source or parts.scheme or parts.netloc:
                raise KeyError
            return self.archive.read(posixpath.normpath(unquote(parts.path)))
        except KeyError:
            raise self.error(where, f"its file `{source}` is not in the archive; put it there") from None
        except (OSError, zipfile.BadZipFile, RuntimeError, NotImplementedError) as error:
            raise self.error(source, f"{error}; pack the archive anew") from None

    def xml(self, source: str, where: str = "the system") -> Element:
        try:
            root = ElementTree.fromstring(self.content(source, where))
        except ElementTree.ParseError as error:
            raise self.error(source, f"no XML: {error}") from None
        for element in root.iter():
            element.tag = element.tag.rpartition("}")[2]
        return root

    def system(self, path: str, system: Element) -> None:
        """Reads a system: an outer one's parameters override an inner one's, so they come later."""
        self.structure.systems.add(path)
        self.connectors(path, system)
        for element in system.iterfind("Elements/*"):
            below = f"{path}.{element.get('name')}".lstrip(".")
            if element.tag == "System":
                self.system(below, element)
            elif element.tag == "Component":
                self.component(below, element)
            else:
                raise self.error(below, f"a {element.tag} is not carried over; connect the components directly")
        for connection in system.iterfind("Connections/Connection"):
            start, end = (
                (f"{path}.{connection.get(f'{side}Element', '')}".strip("."), connection.get(f"{side}Connector", "")) for side in ("start", "end")
            )
            shown = f"the connection {'.'.join(start).lstrip('.')} -> {'.'.join(end).lstrip('.')}"
            component = self.structure.components.get(end[0])
            if component is not None and component.variables.get(end[1], {}).get("causality") == "output":
                # Some write the connection to an output of the system from its end.
                start, end = end, start
            if any(child.tag.endswith(("Transformation", "Mapping")) for child in connection):
                raise self.error(shown, "it transforms values, which are passed on as they are; put an FMU for that between")
            if end in self.structure.feeds:
                raise self.error(shown, "its end has another start already; remove one of them")
            self.structure.feeds[end] = start, connection.get("suppressUnitConversion") in ("true", "1")
        self.bindings(path, system)

    def connectors(self, path: str, element: Element) -> None:
        self.structure.connectors.update({(path, each.get("name", "")): each for each in element.iterfind("Connectors/Connector")})

    def component(self, path: str, element: Element) -> None:
        self.connectors(path, element)
        if (kind := element.get("type", "application/x-fmu-sharedlibrary")) != "application/x-fmu-sharedlibrary":
            raise self.error(path, f"it is no FMU ({kind}); put its FMUs into this system")
        name = re.sub(r"[^A-Za-z0-9]", "_", path)
        while (target := self.folder / f"{name}.fmu").exists():
            name += "_"
        target.write_bytes(self.content(element.get("source", ""), path))
        try:
            with zipfile.ZipFile(target) as fmu:
                held = {name.split("/")[1] for name in fmu.namelist() if re.match("binaries/.*/", name)}
                root = ElementTree.fromstring(fmu.read("modelDescription.xml"))
        except (zipfile.BadZipFile, KeyError, ElementTree.ParseError):
            raise self.error(path, f"{element.get('source')} is no FMU") from None
        if (version := root.get("fmiVersion", "")[:1]) not in ("2", "3"):
            raise self.error(path, "an FMU of FMI 1.0; export it as FMI 2.0")
        if root.find("CoSimulation") is None:
            raise self.error(path, "an FMU for Model Exchange only; export it for Co-Simulation")
        here = PLATFORMS.get(sys.platform, (sys.platform,))
        if not held.intersection(here):
            raise self.error(path, f"the FMU has no binary for {here[0]}, but for {', '.join(sorted(held)) or 'none'}; export it for {here[0]}")
        component = Component(target.name, int(version), {}, units_in(root, "UnitDefinitions"))
        types: dict[str | None, dict[str, Any]] = {}
        for each in root.iterfind("TypeDefinitions/*"):
            items = {item.get("name"): item.get("value") for item in each.iter("Item")}
            types[each.get("name")] = {**each.attrib, **(each[0].attrib if version == "2" else {}), "items": items}
        for variable in root.iterfind("ModelVariables/*"):
            inner = variable[0] if version == "2" else variable
            known = {**types.get(inner.get("declaredType"), {}), **inner.attrib, **variable.attrib, "kind": inner.tag}
            own = known["name"], known.get("unit")
            said = next((child.get("unit") for child in self.structure.connectors.get((path, own[0]), ()) if child.get("unit")), None)
            if meaning(said or "", self.units) and conversion(said, self.units, own[1], component.units) != SAME:
                raise self.error((path, own[0]), f"the connector's unit {said} is not the FMU's, {own[1]}; state that one")
            if said and not own[1]:
                known["unit"] = said
                component.units.setdefault(said, self.units.get(said, ElementTree.Element("Unit", name=said)))
            component.variables[own[0]] = known
        self.structure.components[path] = component
        self.bindings(path, element)

    def bindings(self, path: str, element: Element) -> None:
        """Takes the values of parameter sets."""

        def inside(element: Element | None, name: str) -> Element | None:
            """A set or a mapping, which stands here or in a file of its own."""
            source = None if element is None else element.get("source")
            return self.xml(source, path or "the system") if source else None if element is None else element.find(name)

        for binding in element.iterfind("ParameterBindings/ParameterBinding"):
            parameters = inside(binding, "ParameterValues/ParameterSet")
            if parameters is None:
                raise self.error(path or "the system", "a parameter binding has no values")
            units = {**self.units, **units_in(parameters, "Units")}
            values = {each.get("name", ""): next(iter(each), None) for each in parameters.iterfind("Parameters/Parameter")}
            mapping = inside(binding.find("ParameterMapping"), "ParameterMapping")
            pairs: list[tuple[str, str, Element | None]] = [(name, name, None) for name in values]
            if mapping is not None:
                pairs = [(each.get("source", ""), each.get("target", ""), next(iter(each), None)) for each in mapping.iterfind("MappingEntry")]
            for name, target, change in pairs:
                value, node = values.get(name), self.node(path, binding.get("prefix", "") + target)
                if value is None or node is None:
                    self.structure.unused.append(".".join(filter(None, [path, target])))
                    continue
                text, unit = value.get("value", ""), value.get("unit")
                if change is not None:
                    if change.tag != "LinearTransformation":
                        raise self.error(node, f"the {change.tag} of its parameter is not carried over; state the value itself")
                    # It leads to the unit of its target.
                    text, unit = self.linear(node, text, (float(change.get("factor", 1)), float(change.get("offset", 0)))), None
                self.structure.values[node] = text, unit, units

    def linear(self, node: Node, text: str, change: tuple[float, float]) -> str:
        try:
            return text if change == SAME else repr(float(text) * change[0] + change[1])
        except ValueError:
            raise self.error(node, f"its parameter `{text}` is no number") from None

    def node(self, path: str, name: str) -> Node | None:
        """What a parameter's name means in a component or system."""
        component = self.structure.components.get(path)
        if component is not None or (path, name) in self.structure.connectors:
            return (path, name) if component is None or name in component.variables else None
        # A name may hold dots, so the longest one that fits.
        parts = name.split(".")
        for count in range(len(parts) - 1, 0, -1):
            below = ".".join(filter(None, [path, *parts[:count]]))
            if below in self.structure.components or below in self.structure.systems:
                return self.node(below, ".".join(parts[count:]))
        return None


class Builder:
    """Makes the FMU of what was read."""

    def __init__(self, reader: Reader, library: Any) -> None:
        self.reader, self.structure, self.make = reader, reader.structure, library.FMUContainer
        versions = {component.fmi for component in self.structure.components.values()}
        self.fmi = versions.pop() if len(versions) == 1 else 2
        self.types = set(library.EmbeddedFMUPort.CONTAINER_TO_FMI[self.fmi]) - {"binary", "clock"}
        self.inner = self.make("coupled", reader.folder, fmi_version=self.fmi)
        for component in self.structure.components.values():
            self.inner.get_fmu(component.file)
        self.exposed: dict[str, tuple[str, dict[str, Any]]] = {}

    def build(self, step: float, target: Path) -> None:
        """Writes the FMU."""
        self.check()
        for path, component in self.structure.components.items():
            for name in component.variables:
                self.wire(path, name)
        for path, name in self.structure.connectors:
            if not path and self.structure.connectors[path, name].get("kind") == "output":
                (origin, variable), _ = self.source((path, name))
                if origin in self.structure.components:
                    self.inner.add_output(self.structure.components[origin].file, variable, name)
                    self.exposed[name] = origin, self.structure.components[origin].variables[variable]
                else:
                    print(f"warning: nothing feeds the output {name}; it is left out", file=sys.stderr)
        for path, component in self.structure.components.items():
            for name in component.variables:
                node, _ = self.source((path, name))
                value = self.structure.values.get(node, self.structure.values.get((path, name)))
                if value is not None:
                    start(self.inner, component.file, name, self.text(path, name, *value))
        self.inner.make_fmu("coupled.fmu", step / MOST, ts_multiplier=True)
        self.around(step, target)

    def around(self, step: float, target: Path) -> None:
        """The container around the container."""
        outer = self.make(re.sub(r"[^A-Za-z0-9_]", "_", target.stem), self.reader.folder, fmi_version=self.fmi)
        outer.get_fmu("coupled.fmu")
        for experiment in self.reader.root.iterfind("DefaultExperiment"):
            outer.start_time, outer.stop_time = experiment.get("startTime"), experiment.get("stopTime")
        for name in [MULTIPLIER, *self.inner.inputs]:
            outer.add_input(name, "coupled.fmu", name)
        for name in self.inner.outputs:
            outer.add_output("coupled.fmu", name, name)
        start(outer, "coupled.fmu", MULTIPLIER, str(MOST))
        write = outer.make_fmu_xml

        def described(path: Path, *rest: Any) -> None:
            write(path, *rest)
            self.describe(path, step)

        outer.make_fmu_xml = described
        outer.make_fmu("system.fmu", step / MOST)
        part = target.with_name(f".{target.name}.part")
        copyfile(self.reader.folder / "system.fmu", part)
        part.replace(target)

    def check(self) -> None:
        """Every connection has two ends that are there."""
        for end, (begin, _) in self.structure.feeds.items():
            for node in (begin, end):
                component = self.structure.components.get(node[0])
                known = node in self.structure.connectors if component is None else node[1] in component.variables
                if not known:
                    raise self.reader.error(node, "a connection names it, but there is no such connector; mend the name")
            component = self.structure.components.get(end[0])
            if component is not None and component.variables[end[1]].get("causality") not in ("input", "parameter"):
                raise self.reader.error(end, "a connection ends there, but it is no input of the FMU; turn the connection round")

    def source(self, node: Node) -> tuple[Node, bool]:
        """Where a value comes from, over the levels of the system; whether its unit may be another."""
        seen, free = [node], False
        while node in self.structure.feeds:
            node, suppressed = self.structure.feeds[node]
            free |= suppressed
            if node in seen:
                raise self.reader.error(node, "it is connected to itself; remove one of the connections")
            seen.append(node)
        return node, free

    def wire(self, path: str, name: str) -> None:
        """Connects a variable of a component, or makes it one of the FMU's."""
        component = self.structure.components[path]
        port, variable = self.inner.involved_fmu[component.file].ports.get(name), component.variables[name]
        if port is None:
            return
        is_plain = not port.dimensions and port.type_name in self.types
        if is_plain and (port.causality == "output" or port.causality == "local" and (path, name) in self.structure.connectors):
            self.inner.add_output(component.file, name, f"{path}.{name}")
            self.exposed[f"{path}.{name}"] = path, variable
        elif port.causality in ("input", "parameter"):
            node, free = self.source((path, name))
            given = self.structure.components.get(node[0])
            if given is not None and node != (path, name):
                units = given.variables[node[1]].get("unit"), variable.get("unit")
                if not free and conversion(units[0], given.units, units[1], component.units) != SAME:
                    raise self.reader.error(
                        f"the connection {'.'.join(node)} -> {path}.{name}",
                        f"{units[0]} is not known to be {units[1]}, and values are passed on as they are; put an FMU for that between, or "
                        "state suppressUnitConversion",
                    )
                self.inner.add_link(given.file, node[1], component.file, name)
            elif is_plain:
                shown = ".".join(filter(None, node))
                self.inner.add_input(shown, component.file, name)
                self.exposed.setdefault(shown, (path, variable))

    def text(self, path: str, name: str, text: str, unit: str | None, units: Units) -> str:
        """A parameter's value in the FMU's unit."""
        component = self.structure.components[path]
        variable = component.variables[name]
        if variable["kind"] == "Enumeration":
            return str(variable.get("items", {}).get(text, text))
        if variable["kind"] not in REALS:
            return text
        change = conversion(unit, units, variable.get("unit"), component.units)
        if change is None:
            raise self.reader.error((path, name), f"its parameter's unit {unit} is not known to be {variable['unit']}; state it in that one")
        return self.reader.linear((path, name), text, change)

    def describe(self, path: Path, step: float) -> None:
        """Writes what the library leaves out of the description."""
        root = ElementTree.parse(path).getroot()
        root.attrib.pop("author", None)
        root.attrib.pop("license", None)
        root.set("description", f"The system {self.reader.path.name} of {', '.join(self.structure.components)}")
        for experiment in root.iterfind("DefaultExperiment"):
            experiment.set("stepSize", repr(step))
        for interface in root.iterfind("CoSimulation") if self.fmi == 3 else ():
            # The library writes it, but FMI 3.0 has it no more.
            interface.attrib.pop("canNotUseMemoryManagementFunctions", None)
        units: Units = {}
        for variable in root.iterfind("ModelVariables/*"):
            name = variable.attrib["name"]
            if name == MULTIPLIER:
                said = f"The FMUs exchange values every {step / MOST!r} s times this: {MOST} is the step asked for, which the step check halves"
                variable.attrib.update(causality="parameter", variability="fixed", description=said)
            elif name in self.exposed:
                origin, known = self.exposed[name]
                inner = variable[0] if self.fmi == 2 else variable
                usual = "continuous" if known["kind"] in REALS else "discrete"
                variable.attrib.update(causality=known.get("causality", "local"), variability=known.get("variability", usual))
                inner.attrib.update({key: known[key] for key in LEFT_OUT if key in known})
                if "unit" in known:
                    inner.set("unit", defined(units, known["unit"], self.structure.components[origin].units, origin))
        if units:
            definitions = ElementTree.Element("UnitDefinitions")
            definitions.extend(units.values())
            # Its place by the standard.
            root.insert(1, definitions)
        ElementTree.ElementTree(root).write(path, encoding="utf-8", xml_declaration=True)


def start(container: Any, file: str, name: str, text: str) -> None:
    """A start value. An input's is set again on entering initialisation, over what the host has set; a parameter's is not."""
    container.involved_fmu[file].ports[name].causality = "parameter"
    container.add_start_value(file, name, text)


def defined(units: Units, name: str, own: Units, path: str) -> str:
    """The name under which a component's unit is defined: another one where two mean different things by it."""
    if name in units and meaning(name, units) != meaning(name, own):
        name, own = f"{name} of {path}", {f"{name} of {path}": own[name]} if name in own else {}
    known = units.setdefault(name, ElementTree.Element("Unit", name=name))
    held = {(child.tag, child.get("name")) for child in known}
    known.extend(child for child in own.get(name, ()) if (child.tag, child.get("name")) not in held)
    return name


class Remarks(logging.Handler):
    """The library's remarks that matter: loops, which have no values at the start, and numbers that lose digits."""

    def emit(self, record: logging.LogRecord) -> None:
        if (text := record.getMessage()).startswith(("Loop", "Lossy")):
            print(f"warning: {text}", file=sys.stderr)


def system(path: str | Path, step: float, output: str | Path, *, force: bool = False) -> None:
    """Makes one FMU of an SSP, whose FMUs exchange values every `step` seconds."""
    path, output = Path(path), Path(output)
    if not MOST * SAME_TIME < step < float("inf"):
        raise OrchestratorError(f"--step {step}: a number of seconds above {MOST * SAME_TIME} is needed")
    if output.exists() and not force:
        raise OrchestratorError(f"{output} is there already; name another file, or give --force")
    try:
        library = importlib.import_module("fmu_manipulation_toolbox.container")
    except ImportError:
        raise OrchestratorError('fmu-manipulation-toolbox is missing: pip install "fmu-orchestrator[system]"') from None
    logger = logging.getLogger("fmu_manipulation_toolbox")
    logger.propagate, logger.handlers = False, [Remarks()]
    with tempfile.TemporaryDirectory(prefix="system-") as folder:
        try:
            reader = Reader(path, Path(folder))
            builder = Builder(reader, library)
            builder.build(step, output)
        except library.FMUContainerError as error:
            raise OrchestratorError(f"{path}: {error}") from None
        except (ValueError, LookupError) as error:
            raise OrchestratorError(f"{path}: something in it is not by the standard: {error!r}") from None
        except OSError as error:
            raise OrchestratorError(f"{output}: {error.strerror or error}; name a folder that can be written") from None
    if unused := reader.structure.unused:
        print(f"warning: {len(unused)} parameters have no value or fit no variable, and are left out: {', '.join(unused[:3])}", file=sys.stderr)
    count = len(reader.structure.components)
    print(f"{output}: {count} FMUs that exchange values every {step} s, {len(builder.exposed)} variables")


def main(arguments: list[str]) -> int:
    """The command `system`."""
    parser = argparse.ArgumentParser(prog="python -m fmu_orchestrator system", description="Makes one FMU of a system of FMUs (SSP).")
    parser.add_argument("ssp", help="the system: a zip archive with SystemStructure.ssd")
    parser.add_argument("--step", type=float, required=True, help="the FMUs exchange values that often, s")
    parser.add_argument("--output", required=True, help="the FMU")
    parser.add_argument("--force", action="store_true", help="replace a file that is there")
    given = parser.parse_args(arguments)
    system(given.ssp, given.step, given.output, force=given.force)
    return 0
