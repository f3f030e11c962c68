"""Parameter sets that go into the FMU: complete SSP parameter values (SSV 1.0), one a calibration.

They are made of the model description's start values and of the studies, so that there is one place
for each number. Where they lie and how they are told of follows the layered standard FMI-LS-REF.
"""

import tomllib
import xml.etree.ElementTree as ET
from xml.sax.saxutils import quoteattr

from .common import ROOT

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
SETS = {
    "rig": ("rig.toml", "The measured test rig: the start values, calibrated to the experiment (docs: calibration B)"),
    "paper-table3": ("paper-table3.toml",
                     "The effective model behind the paper's Table 3: a thick oil, no asperity contact (docs: calibration A)"),
}


def files():
    """The files by their names in the FMU."""
    description = ET.parse(ROOT / "modelDescription/modelDescription.xml").getroot()
    made = {f"{name}.ssv": parameter_set(description, name, study, about).encode()
            for name, (study, about) in SETS.items()}
    made["fmi-ls-manifest.xml"] = manifest(made).encode()
    return {f"{FOLDER}/{name}": content for name, content in made.items()}


def typed(variable):
    """The element of a variable's type."""
    return next(child for child in variable if child.tag in ("Real", "Integer", "Boolean", "Enumeration", "String"))


def parameter_set(description, name, study, about):
    values = study_values(description, ROOT / "studies" / study)
    lines, used = [], {}
    for variable in description.iter("ScalarVariable"):
        if variable.get("causality") != "parameter":
            continue
        element, key = typed(variable), variable.get("name")
        value = values.get(key, element.get("start"))
        # SSV 1.0 names the items of enumerations; importers of FMI 2.0 take numbers.
        kind = "Integer" if element.tag == "Enumeration" else element.tag
        unit = element.get("unit")
        if unit:
            used[unit] = True
        given = f" unit={quoteattr(unit)}" if unit else ""
        lines.append(f'    <ssv:Parameter name="{key}"><ssv:{kind} value={quoteattr(str(value))}{given}/></ssv:Parameter>')
    units = [unit_definition(unit) for unit in description.iter("Unit") if unit.get("name") in used]
    return "\n".join([
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<ssv:ParameterSet xmlns:ssv="http://ssp-standard.org/SSP1/SystemStructureParameterValues"'
        ' xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon"'
        f' version="1.0" name="{name}" description={quoteattr(about)}>',
        "  <ssv:Parameters>", *lines, "  </ssv:Parameters>",
        "  <ssv:Units>", *units, "  </ssv:Units>", "</ssv:ParameterSet>", ""])


def unit_definition(unit):
    base = unit.find("BaseUnit")
    exponents = "".join(f' {name}="{value}"' for name, value in (base.attrib if base is not None else {}).items())
    return f'    <ssc:Unit name={quoteattr(unit.get("name"))}><ssc:BaseUnit{exponents}/></ssc:Unit>'


def study_values(description, path):
    """A study's nominal and fixed values in SI units."""
    study = tomllib.loads(path.read_text(encoding="utf-8"))
    variables = {variable.get("name"): typed(variable) for variable in description.iter("ScalarVariable")}
    found = {}
    for name, spread in study.get("parameters", {}).items():
        nominal = next(spread[key] for key in ("mean", "value", "mode") if key in spread)
        found[name] = in_si(description, variables[name], nominal, spread.get("unit"))
    for name, value in study.get("fixed", {}).items():
        if variables[name].tag == "Enumeration":
            found[name] = item_value(description, variables[name], value)
            continue
        number, _, unit = value.partition(" ") if isinstance(value, str) else (value, "", "")
        found[name] = in_si(description, variables[name], float(number), unit)
    return found


def item_value(description, element, item):
    """The number of an enumeration's item."""
    types = {kind.get("name"): kind for kind in description.iter("SimpleType")}
    items = {node.get("name"): int(node.get("value")) for node in types[element.get("declaredType")].iter("Item")}
    return items[item]


def in_si(description, element, value, unit):
    """A number in SI units, from the unit or a display unit that the FMU defines."""
    own = element.get("unit")
    if not unit or unit == own:
        return float(value)
    definition = next(node for node in description.iter("Unit") if node.get("name") == own)
    display = next((node for node in definition.iter("DisplayUnit") if node.get("name") == unit), None)
    if display is None:
        raise SystemExit(f"package-fmu: {unit} is no display unit of {own}")
    offset = 0.0 if element.get("relativeQuantity") == "true" else float(display.get("offset", 0))
    # Twelve digits: what the conversion adds beyond them is rounding.
    return float(f"{(value - offset) / float(display.get('factor', 1)):.12g}")


def manifest(made):
    related = [
        f'  <Related type="application/x-ssp-parameter-set" source="{file}" role="parameter"'
        f' description={quoteattr(SETS[file.removesuffix(".ssv")][1])}/>'
        for file in made]
    return "\n".join([
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"'
        ' fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref" fmi-ls:fmi-ls-version="1.0.0-alpha.1"'
        ' fmi-ls:fmi-ls-description="Layered Standard providing information on related files included in an FMU.">',
        *related, "</fmiReferences>", ""])
