"""JUnit XML of adjustments: one test suite a project, one test case a criterion, for systems that read test reports.

The elements and attributes are those that the schemas in use share (Jenkins xUnit plugin, junit-10.xsd; pytest's
xunit2): testsuites > testsuite > properties, testcase > failure | error | skipped.  The file of a single adjustment
holds no time, so that the same result gives the same bytes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from xml.etree import ElementTree

from splinebba_cli.core.evidence import Criterion
from splinebba_cli.errors import SplinebbaError

_NOT_XML = re.compile(r"[^\t\n\r\u0020-\uD7FF\uE000-\uFFFD\U00010000-\U0010FFFF]")
_SOLVED = "adjustment"


@dataclass(frozen=True)
class Suite:
    """The test suite of a project.

    Attributes
    ----------
    name : str
        Of the project.
    criteria : sequence of Criterion
        A failure for each that failed or could not be tested.
    error : Trouble, optional
        Why there is no result.
    skipped : str
        Why the project was not adjusted; empty where it was.
    properties : mapping
        Key figures, as text.
    seconds : float
        Time of the adjustment.
    """

    name: str
    criteria: Sequence[Criterion] = ()
    error: Trouble | None = None
    skipped: str = ""
    properties: Mapping[str, str] = field(default_factory=dict)
    seconds: float = 0.0


@dataclass(frozen=True)
class Trouble:
    """Why there is no result: error code, one line, all of it."""

    code: str
    message: str
    text: str


def junit_of_criteria(project: str, criteria: Sequence[Criterion]) -> str:
    """The file of one finished adjustment."""
    return junit_text([Suite(project, criteria)])


def junit_of_error(project: str, error: SplinebbaError) -> str:
    """The file of one project that is invalid or has no solution."""
    trouble = Trouble(error.code, error.message, f"{error.message}\n{error.help}".strip())
    return junit_text([Suite(project, error=trouble)])


def junit_text(suites: Sequence[Suite]) -> str:
    """The file of all suites."""
    elements = [_suite(suite) for suite in suites]
    keys = ("tests", "failures", "errors")
    counts = {key: str(sum(int(element.attrib[key]) for element in elements)) for key in keys}
    seconds = _number(sum(suite.seconds for suite in suites))
    root = ElementTree.Element("testsuites", {"name": "splinebba", **counts, "time": seconds})
    root.extend(elements)
    ElementTree.indent(root)
    body = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'


def _suite(suite: Suite) -> ElementTree.Element:
    cases = [_adjustment(suite), *(_case_of(suite.name, criterion) for criterion in suite.criteria)]
    counts = {
        "tests": len(cases),
        "failures": sum(case.find("failure") is not None for case in cases),
        "errors": sum(case.find("error") is not None for case in cases),
        "skipped": sum(case.find("skipped") is not None for case in cases),
    }
    attributes = {key: str(count) for key, count in counts.items()}
    element = ElementTree.Element(
        "testsuite", {"name": _clean(suite.name), **attributes, "time": _number(suite.seconds)}
    )
    if suite.properties:
        properties = ElementTree.SubElement(element, "properties")
        for name, value in suite.properties.items():
            ElementTree.SubElement(properties, "property", {"name": name, "value": _clean(value)})
    element.extend(cases)
    return element


def _adjustment(suite: Suite) -> ElementTree.Element:
    """Whether there is a result at all."""
    case = _case(suite.name, _SOLVED, suite.seconds)
    if suite.error is not None:
        attributes = {"message": _clean(suite.error.message), "type": suite.error.code}
        ElementTree.SubElement(case, "error", attributes).text = _clean(suite.error.text)
    elif suite.skipped:
        ElementTree.SubElement(case, "skipped", {"message": _clean(suite.skipped)})
    return case


def _case_of(project: str, criterion: Criterion) -> ElementTree.Element:
    case = _case(project, criterion.key)
    if criterion.status != "passed":
        attributes = {"message": _clean(criterion.message), "type": criterion.status}
        ElementTree.SubElement(case, "failure", attributes).text = _clean(_detail(criterion))
    return case


def _detail(criterion: Criterion) -> str:
    lines = [criterion.message]
    if criterion.value is not None:
        lines.append(f"value: {criterion.value:.6g} {criterion.unit}".rstrip())
    if criterion.limit is not None:
        lines.append(f"limit: {criterion.limit:g} {criterion.unit}".rstrip())
    if criterion.subject:
        lines.append(f"subject: {criterion.subject}")
    return "\n".join(lines)


def _case(project: str, name: str, seconds: float = 0.0) -> ElementTree.Element:
    attributes = {"name": name, "classname": _clean(project), "time": _number(seconds)}
    return ElementTree.Element("testcase", attributes)


def _number(seconds: float) -> str:
    return f"{seconds:.3f}".rstrip("0").rstrip(".")


def _clean(text: str) -> str:
    """Text without the characters that XML cannot hold."""
    return _NOT_XML.sub("�", text)
