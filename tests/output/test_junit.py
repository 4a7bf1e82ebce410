"""JUnit XML as CI systems read it: counts, failures with messages, no characters that XML forbids."""

from __future__ import annotations

from xml.etree import ElementTree

from splinebba_cli.core.evidence import Criterion
from splinebba_cli.errors import NotConvergedError
from splinebba_cli.output.junit import junit_of_criteria, junit_of_error

CRITERIA = (
    Criterion("max_sigma0", "σ̂₀", 0.9, 1.2, "", "passed", "σ̂₀ 0.9 is within 1.2"),
    Criterion(
        "max_position_sigma_m",
        "σ",
        0.3,
        0.1,
        "m",
        "failed",
        "image `<1>\x00`: 0.3 m exceeds 0.1 m",
        "image `<1>`",
    ),
    Criterion("check_tests", "tests", None, None, "", "untested", "not tested: there are no check points"),
)
# attributes that the schema of the Jenkins xUnit plugin (junit-10.xsd) requires and allows
REQUIRED = {"testsuite": {"name", "tests", "failures", "errors"}, "testcase": {"name"}}
ALLOWED = {
    "testsuites": {"name", "time", "tests", "failures", "errors"},
    "testsuite": {"name", "tests", "failures", "errors", "group", "time", "skipped", "timestamp", "hostname", "id",
                  "package", "file", "log", "url"},
    "testcase": {"name", "classname", "time", "group"},
    "failure": {"type", "message"},
    "error": {"type", "message"},
}  # fmt: skip


def checked(text: str) -> ElementTree.Element:
    """The root, after the attributes, the nesting and the counts were held against the schema."""
    root = ElementTree.fromstring(text.encode("utf-8"))
    assert root.tag == "testsuites"
    for element in root.iter():
        assert REQUIRED.get(element.tag, set()) <= set(element.attrib) <= ALLOWED[element.tag], element.tag
    (suite,) = root
    assert suite.tag == "testsuite" and {case.tag for case in suite} == {"testcase"}
    for tag, count in (("failure", "failures"), ("error", "errors")):
        assert int(suite.attrib[count]) == int(root.attrib[count]) == len(list(suite.iter(tag)))
    assert int(suite.attrib["tests"]) == len(suite)
    return root


def test_one_case_a_criterion() -> None:
    root = checked(junit_of_criteria("Block & <two>", CRITERIA))
    cases = {case.attrib["name"]: case for case in root.iter("testcase")}
    assert list(cases) == ["adjustment", "max_sigma0", "max_position_sigma_m", "check_tests"]
    assert {case.attrib["classname"] for case in cases.values()} == {"Block & <two>"}
    failed = cases["max_position_sigma_m"].find("failure")
    assert failed is not None and failed.attrib["type"] == "failed"
    assert failed.attrib["message"] == "image `<1>�`: 0.3 m exceeds 0.1 m"
    assert failed.text is not None and "limit: 0.1 m" in failed.text and "value: 0.3 m" in failed.text
    untested = cases["check_tests"].find("failure")
    assert untested is not None and untested.attrib["type"] == "untested"
    assert len(cases["max_sigma0"]) == 0


def test_no_solution_is_an_error() -> None:
    root = checked(junit_of_error("block", NotConvergedError([], "no convergence")))
    (found,) = root.iter("error")
    assert found.attrib == {"message": "no convergence", "type": "SBB502"}
