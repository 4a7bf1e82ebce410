"""JUnit XML of an adjustment: one test case a criterion of the project, for systems that read test reports.

The elements and attributes are those that the schemas in use share (Jenkins xUnit plugin, junit-10.xsd; pytest's
xunit2): testsuites > testsuite > testcase > failure | error.  Files hold no time, so that the same result gives the
same bytes.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from xml.etree import ElementTree

from splinebba_cli.core.evidence import Criterion
from splinebba_cli.errors import SplinebbaError

_NOT_XML = re.compile(r"[^\t\n\r\u0020-\uD7FF\uE000-\uFFFD\U00010000-\U0010FFFF]")
_SOLVED = "adjustment"


def junit_of_criteria(project: str, criteria: Sequence[Criterion]) -> str:
    """The file of a finished adjustment.

    Parameters
    ----------
    project : str
        Name of the project.
    criteria : sequence of Criterion
        A failure for each that failed or could not be tested.
    """
    cases = [_case(project, _SOLVED)]
    for criterion in criteria:
        case = _case(project, criterion.key)
        if criterion.status != "passed":
            failure = ElementTree.SubElement(
                case, "failure", {"message": _clean(criterion.message), "type": criterion.status}
            )
            failure.text = _clean(_detail(criterion))
        cases.append(case)
    return _text(project, cases)


def junit_of_error(project: str, error: SplinebbaError) -> str:
    """The file of a project that is invalid or has no solution."""
    case = _case(project, _SOLVED)
    found = ElementTree.SubElement(case, "error", {"message": _clean(error.message), "type": error.code})
    found.text = _clean(f"{error.message}\n{error.help}".strip())
    return _text(project, [case])


def _detail(criterion: Criterion) -> str:
    lines = [criterion.message]
    if criterion.value is not None:
        lines.append(f"value: {criterion.value:.6g} {criterion.unit}".rstrip())
    if criterion.limit is not None:
        lines.append(f"limit: {criterion.limit:g} {criterion.unit}".rstrip())
    if criterion.subject:
        lines.append(f"subject: {criterion.subject}")
    return "\n".join(lines)


def _case(project: str, name: str) -> ElementTree.Element:
    return ElementTree.Element("testcase", {"name": name, "classname": _clean(project), "time": "0"})


def _text(project: str, cases: list[ElementTree.Element]) -> str:
    counts = {
        "tests": str(len(cases)),
        "failures": str(sum(case.find("failure") is not None for case in cases)),
        "errors": str(sum(case.find("error") is not None for case in cases)),
        "time": "0",
    }
    root = ElementTree.Element("testsuites", {"name": "splinebba", **counts})
    suite = ElementTree.SubElement(root, "testsuite", {"name": _clean(project), **counts, "skipped": "0"})
    suite.extend(cases)
    ElementTree.indent(root)
    body = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{body}\n'


def _clean(text: str) -> str:
    """Text without the characters that XML cannot hold."""
    return _NOT_XML.sub("�", text)
