"""The date in a PDF that a browser has made: that of the results, so that the same results give the same bytes."""

from __future__ import annotations

import re

from splinebba_cli.report.result_data import ResultData

_DATES = re.compile(rb"(/(?:CreationDate|ModDate) \(D:)(\d{14})")


def dated_pdf(pdf: bytes, data: ResultData) -> bytes:
    """The same PDF, created when the results were written.

    Parameters
    ----------
    pdf : bytes
        As a browser has printed it.
    data : ResultData
        Its ``provenance`` has the time (UTC).

    Returns
    -------
    bytes
        As many as before: the places of the objects in the file hold.
    """
    written = str(data["provenance"].get("timestamps", {}).get("written", ""))
    digits = re.sub(r"\D", "", written)[:14]
    if len(digits) != 14:
        return pdf
    return _DATES.sub(rb"\g<1>" + digits.encode("ascii"), pdf)
