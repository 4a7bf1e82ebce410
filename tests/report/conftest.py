"""Fixtures of the tests of reports."""

from tests.report.browser import browser, page_of, sample_reports, watched

__all__ = ["browser", "page_of", "sample_reports", "watched"]
