"""How the iterations went, and where the result comes from."""

from __future__ import annotations

from splinebba_cli.report.blocks import Block, Cell, Column, Fact, Facts, Section, Table
from splinebba_cli.report.residual_figure_blocks import convergence_blocks
from splinebba_cli.report.result_data import ResultData


def convergence_section(data: ResultData) -> Section:
    """The convergence log."""
    log = data["convergence"]
    status = data["status"]
    facts = Facts(
        (
            Fact(
                "Converged",
                "yes" if status["converged"] else "no",
                "",
                "good" if status["converged"] else "bad",
            ),
            Fact("Termination", status["termination"]),
            Fact("Iterations", f"{status['iterations']}"),
        )
    )
    blocks: list[Block] = [facts]
    if log:
        blocks += convergence_blocks(log)
        columns = (
            Column("Stage", numeric=False),
            Column("Iteration"),
            Column("v′Pv", numeric=True),
            Column("Largest step", "σ"),
            Column("Damping"),
        )
        rows: tuple[tuple[Cell, ...], ...] = tuple(
            (line["stage"], line["iteration"], line["cost"], line["step"], line["damping"]) for line in log
        )
        blocks.append(Table("Convergence log", columns, rows, source="result.json", folded=True))
    return Section("convergence", "Convergence", tuple(blocks))


def provenance_section(data: ResultData) -> Section:
    """Program, libraries, inputs, times."""
    provenance = data["provenance"]
    if not provenance:
        return Section("provenance", "Provenance", ())
    program, libraries = provenance["program"], provenance["libraries"]
    times = provenance["timestamps"]
    items = [
        Fact("Project", provenance["project"]["name"], provenance["project"]["file"]),
        Fact("Program", f"{program['name']} {program['version']}"),
        Fact("Libraries", ", ".join(f"{name} {version}" for name, version in libraries.items())),
        Fact("Platform", provenance["platform"]),
        Fact("Written", times["written"].replace("T", " ").replace("Z", " UTC")),
    ]
    if times["timings_s"]:
        items.append(
            Fact(
                "Times",
                ", ".join(
                    f"{stage.removesuffix('_s')} {seconds:.2f} s"
                    for stage, seconds in times["timings_s"].items()
                ),
            )
        )
    columns = (Column("File", numeric=False), Column("SHA-256", numeric=False))
    rows = tuple((source["file"], source["sha256"]) for source in provenance["inputs"])
    return Section("provenance", "Provenance", (Facts(tuple(items)), Table("Input files", columns, rows)))
