"""Every way in which the program says no: exceptions, error codes, exit codes.

This module imports nothing heavy, so that every layer and the start-up may import it.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import IntEnum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from splinebba_cli.core.result import Problem
    from splinebba_cli.project.diagnostics import Diagnostic


class ExitCode(IntEnum):
    """What the shell gets."""

    DONE = 0  # done and accepted
    NOT_ACCEPTED = 1  # adjusted, but an acceptance criterion of the project failed
    INVALID = 2  # invalid project or usage
    NOT_SOLVABLE = 3  # rank defect, no convergence
    BUG = 70  # an error of the program itself


ERROR_CODES: dict[str, str] = {
    # 1xx: the text of the project file
    "SBB101": "the file cannot be read",
    "SBB102": "YAML syntax error",
    "SBB103": "the file is not UTF-8",
    "SBB104": "duplicate key",
    "SBB105": "too many or too deep aliases",
    "SBB106": "the project is not a mapping",
    "SBB107": "merge keys or tags are not supported",
    "SBB108": "a key is not a text",
    "SBB109": "the project file is too large",
    # 2xx: the project against its schema
    "SBB201": "unknown key",
    "SBB202": "missing key",
    "SBB203": "wrong type",
    "SBB204": "value not allowed",
    "SBB205": "value out of range",
    "SBB206": "wrong shape",
    "SBB207": "not a finite number",
    "SBB208": "not available yet",
    "SBB209": "contradictory keys",
    "SBB210": "id or name with characters that are commands elsewhere",
    # 3xx: references between the parts, and their meaning
    "SBB301": "reference to an unknown id",
    "SBB302": "duplicate id",
    "SBB303": "image without observations",
    "SBB304": "tie feature seen by fewer than two images",
    "SBB305": "segment without measurements",
    "SBB306": "coordinates implausibly far apart",
    "SBB307": "too few knots",
    "SBB308": "control without coordinates",
    "SBB309": "sigma is not positive",
    "SBB310": "feature without observations",
    "SBB311": "held knot or segment does not exist",
    "SBB312": "approximate shape missing",
    "SBB313": "measurement outside of the image",
    "SBB314": "prior without a value",
    "SBB315": "image without any way to an approximate orientation",
    "SBB320": "too few points for a curve",
    "SBB321": "coordinates in degrees",
    "SBB322": "heights missing",
    "SBB323": "threshold smaller than the noise of the points",
    "SBB324": "line that returns to its first point",
    "SBB325": "measurements do not fit to the principal distance",
    "SBB326": "angle beyond two full turns",
    "SBB327": "no chains to match",
    "SBB328": "chain in several parts",
    "SBB329": "image points without a label",
    "SBB330": "directions that do not follow their chains",
    "SBB331": "image points given twice",
    "SBB332": "no chains in a file",
    "SBB333": "parts of a file that are no lines",
    "SBB334": "two chains of one name",
    "SBB335": "coordinates that are no pixels",
    "SBB336": "image coordinates mirrored or turned",
    "SBB337": "σ of image points too large",
    # 4xx: tables
    "SBB401": "table not found or unreadable",
    "SBB402": "missing or unknown column",
    "SBB403": "bad value in a table",
    "SBB404": "wrong number of fields in a row",
    "SBB405": "empty table",
    "SBB406": "table format not supported",
    "SBB407": "not GeoJSON, or no lines in it",
    "SBB408": "table outside of the project's folder",
    "SBB409": "table larger than the memory",
    "SBB410": "quotation mark without its end",
    "SBB411": "table with NUL characters",
    "SBB412": "Parquet column of a wrong type",
    # 5xx: adjustment
    "SBB501": "the network is singular",
    "SBB502": "the adjustment did not converge",
    "SBB503": "no approximate values",
    "SBB504": "point intersected at a small angle",
    "SBB505": "approximate values put features behind the images",
    "SBB506": "given orientations do not fit the measurements",
    "SBB510": "acceptance criterion failed",
    "SBB520": "spline not determined",
    "SBB521": "point not determined",
    "SBB522": "orientation not determined",
    "SBB523": "datum not determined",
    "SBB524": "unknowns not determined",
    "SBB530": "no redundancy",
    "SBB531": "the global test fails",
    "SBB532": "gauge conditions take part of the redundancy",
    "SBB533": "spline weak across itself",
    "SBB534": "orientation unknowns highly correlated",
    "SBB535": "spline folded",
    "SBB536": "knot interval without measurements",
    "SBB537": "arc lengths too long for one Simpson step",
    "SBB553": "few check points",
    "SBB554": "check points differ by more than predicted",
    "SBB555": "check points shifted as a whole",
    "SBB556": "check spline farther from its given shape than predicted",
    "SBB557": "the largest standardised residual is no chance",
    "SBB545": "σ of a group does not fit to the others",
    "SBB546": "a group of observations has a common error",
    "SBB547": "mean residual of an image",
    "SBB548": "radial or tangential trend of residuals",
    "SBB549": "residuals run along a spline",
    "SBB550": "residuals drift with the order of the images",
    "SBB551": "residuals agree in parts of the image format",
    "SBB552": "σ of a group not estimated",
    "SBB540": "observations were rejected",
    "SBB541": "the search for outliers stopped early",
    "SBB542": "the weights did not settle",
    "SBB543": "no solution without the outliers",
    "SBB544": "observations excluded by the user",
    "SBB570": "not enough memory for the normal equations",
    "SBB587": "nothing to find an orientation from",
    "SBB588": "no orientation explains the chains",
    "SBB589": "chains do not tell the orientation apart",
    "SBB590": "no tie curves can be built from chains",
    "SBB591": "chains without a curve",
    "SBB592": "chains cut at jumps",
    "SBB593": "matched points fit their splines worse than their σ says",
    "SBB594": "new spline weak across itself",
    "SBB595": "new spline cut where nothing determines it",
    "SBB596": "two splines are the same edge",
    "SBB597": "a second edge beside a new spline",
    "SBB598": "the points of a spline show two edges",
    "SBB599": "nothing was matched",
    # 6xx: output
    "SBB580": "matched curves do not determine an orientation",
    "SBB581": "two orientations fit equally well",
    "SBB582": "no point of an image follows a curve",
    "SBB583": "no adjustment with the matched points",
    "SBB584": "no orientation brings the points of an image onto curves",
    "SBB585": "matched points contradict the principal distance",
    "SBB601": "results cannot be written",
    "SBB602": "not a result folder",
    "SBB603": "the file or folder exists",
    "SBB604": "no room to write",
    "SBB605": "not allowed to write",
    "SBB606": "another run is writing the results",
    "SBB607": "a name that cannot be written",
    "SBB611": "results have nothing in common",
    "SBB612": "results compared after a similarity transformation",
    "SBB613": "results without covariances",
    "SBB614": "results are not related as assumed",
    "SBB620": "no browser to print the report",
    "SBB621": "the browser made no PDF",
    # 7xx: simulation
    "SBB701": "the truth does not fit the project",
    "SBB702": "not enough is known to simulate",
    "SBB703": "another campaign",
    "SBB704": "a worker process ended",
    # 80x, 81x: many projects in one run
    "SBB801": "a worker process was killed",
    "SBB802": "the time limit of a project is over",
    "SBB810": "no project to adjust",
    "SBB811": "results of two projects in one place",
    "SBB815": "the scheduler cannot be used",
    "SBB816": "workers of the scheduler cannot adjust",
    # 82x: projects to start from
    "SBB821": "the polyline cannot carry a block",
    # 9xx: the program
    "SBB900": "usage",
    "SBB901": "interrupted",
    "SBB970": "unexpected error inside the program",
}


class SplinebbaError(Exception):
    """Base of all expected errors.

    Parameters
    ----------
    code : str
        A key of :data:`ERROR_CODES`.
    message : str
        What is wrong, in the user's words.
    help : str
        What would cure it; may be empty.
    """

    exit_code: ExitCode = ExitCode.INVALID

    def __init__(self, code: str, message: str, help: str = "") -> None:
        super().__init__(message)
        self.code = code
        self.message = message
        self.help = help

    def __str__(self) -> str:
        return f"{self.code}: {self.message}"


class UsageError(SplinebbaError):
    """The command was called in a way that makes no sense."""


class FitError(SplinebbaError):
    """Points do not make a curve."""


class OutputError(SplinebbaError):
    """Results cannot be written or read."""


class SimulationError(SplinebbaError):
    """A project cannot be simulated, or a campaign not be continued."""


class ProjectError(SplinebbaError):
    """The project is invalid; carries every diagnostic, in the order of the file."""

    subject = "the project"

    def __init__(self, diagnostics: Sequence[Diagnostic]) -> None:
        self.diagnostics: tuple[Diagnostic, ...] = tuple(diagnostics)
        errors = [d for d in self.diagnostics if d.severity == "error"]
        first = errors[0] if errors else None
        more = f" (and {len(errors) - 1} more)" if len(errors) > 1 else ""
        message = f"{first.message}{more}" if first else "invalid project"
        super().__init__(first.code if first else "SBB203", message, first.help if first else "")


class PointsFileError(ProjectError):
    """A file of digitised points is invalid."""

    subject = "the points"


class ChainsFileError(ProjectError):
    """A file of traced chains is invalid."""

    subject = "the chains"


class NotSolvableError(SplinebbaError):
    """The adjustment has no solution worth reporting.

    Parameters
    ----------
    problems : sequence of Problem
        The diagnosis: what is undetermined or does not converge, and what would cure it.
    message : str
        One line for the console; by default the message of the first problem.
    """

    exit_code = ExitCode.NOT_SOLVABLE
    default_code = "SBB501"

    def __init__(self, problems: Sequence[Problem] = (), message: str = "") -> None:
        self.problems: tuple[Problem, ...] = tuple(problems)
        first = self.problems[0] if self.problems else None
        super().__init__(
            first.code if first else self.default_code,
            message or (first.message if first else ERROR_CODES[self.default_code]),
            first.help if first else "",
        )


class SingularNetworkError(NotSolvableError):
    """Some unknowns are not determined by observations, priors and conditions."""


class NotConvergedError(NotSolvableError):
    """The iterations ended without a negligible step."""

    default_code = "SBB502"


class NotEnoughMemoryError(NotSolvableError):
    """The normal equations need more memory than there is."""

    default_code = "SBB570"
