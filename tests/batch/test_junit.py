"""JUnit XML of a batch: valid, with counts that agree, failures and errors apart."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest

from splinebba_cli.batch.junit import junit_of_batch
from splinebba_cli.batch.outcome import Outcome, Verdict
from splinebba_cli.project.diagnostics import Diagnostic

CRITERIA = [
    {"criterion": "global_test", "title": "global test", "value": None, "limit": None, "unit": "", "status": "passed",
     "message": "accepted", "subject": ""},
    {"criterion": "max_sigma0", "title": "σ̂₀", "value": 1.5, "limit": 1.2, "unit": "", "status": "failed",
     "message": "σ̂₀ 1.5 exceeds 1.2", "subject": ""},
]  # fmt: skip
PROBLEMS = (
    Diagnostic("SBB303", "warning", "image `7` has no observations", "", "b/project.yaml"),
    Diagnostic(
        "SBB201",
        "error",
        "unknown key `rolle`",
        "did you mean `role`?",
        "b/project.yaml",
        3,
        2,
        5,
        " rolle: x",
    ),
    Diagnostic("SBB202", "error", "missing key <&\x01>", "", "b/project.yaml", 1, 1),
)
OUTCOMES = (
    Outcome("a/project.yaml", Verdict.not_accepted, "a", "a/project.results", False, 1.25,
            {"sigma0": 1.5, "redundancy": 12, "observations": 20, "unknowns": 8}, CRITERIA),
    Outcome("b/project.yaml", Verdict.invalid, seconds=0.5, problems=PROBLEMS),
    Outcome("c/project.yaml", Verdict.not_run),
)  # fmt: skip


def validated(text: str) -> ElementTree.Element:
    """The root of a file that agrees with the schema; skips without a validator."""
    xmlschema = pytest.importorskip("xmlschema", reason="the schema is checked with the package xmlschema")
    xmlschema.validate(text, str(Path(__file__).with_name("junit.xsd")))
    return ElementTree.fromstring(text)


def test_suites_cases_and_counts() -> None:
    root = validated(junit_of_batch(OUTCOMES))
    assert [suite.attrib["name"] for suite in root] == [outcome.project for outcome in OUTCOMES]
    assert (root.attrib["tests"], root.attrib["failures"], root.attrib["errors"]) == ("5", "1", "1")
    assert root.attrib["time"] == "1.75"
    counts = [[suite.attrib[key] for key in ("tests", "failures", "errors", "skipped")] for suite in root]
    assert counts == [["3", "1", "0", "0"], ["1", "0", "1", "0"], ["1", "0", "0", "1"]]
    assert [case.attrib["name"] for case in root[0].iter("testcase")] == [
        "adjustment", "global_test", "max_sigma0",
    ]  # fmt: skip


def test_properties() -> None:
    root = validated(junit_of_batch(OUTCOMES))
    properties = {each.attrib["name"]: each.attrib["value"] for each in root[0].iter("property")}
    assert properties == {
        "verdict": "not accepted", "up_to_date": "false", "sigma0": "1.5", "redundancy": "12", "observations": "20",
        "unknowns": "8", "results": "a/project.results",
    }  # fmt: skip


def test_what_prevented_results_is_an_error() -> None:
    root = validated(junit_of_batch(OUTCOMES))
    (failure,), (error,) = root.iter("failure"), root.iter("error")
    assert failure.attrib == {"message": "σ̂₀ 1.5 exceeds 1.2", "type": "failed"}
    assert error.attrib == {"message": "unknown key `rolle` (and 1 more)", "type": "SBB201"}
    assert error.text is not None
    assert "b/project.yaml:3:2" in error.text and "^^^^^" in error.text and "missing key <&�>" in error.text
    assert "SBB303" not in error.text


def test_the_schema_refuses_what_readers_would() -> None:
    xmlschema = pytest.importorskip("xmlschema", reason="the schema is checked with the package xmlschema")
    text = junit_of_batch(OUTCOMES)
    for old, new in (
        ('tests="3" ', ""),
        ("<error ", "<error wrong='1' "),
        ("testcase", "case"),
        ('"1.25"', '"1,25"'),
    ):
        assert old in text
        with pytest.raises(xmlschema.XMLSchemaException):
            xmlschema.validate(text.replace(old, new), str(Path(__file__).with_name("junit.xsd")))
