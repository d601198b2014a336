"""What the commands show: tables, or JSON."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pendpin.doctor.diagnosis import Diagnosis
    from pendpin.fitting import Fit
    from pendpin.motions.crosschecks.report import CheckReport
    from pendpin.motions.trajectory import Trajectory
    from pendpin.stability.lyapunov import Lyapunov
    from pendpin.stability.modes import Modes
    from pendpin.stability.report import Stability
    from pendpin.sweeps.significance import EffectsReport
    from pendpin.verification.agreement.published import Case as Published
    from pendpin.verification.agreement.validate import AgreementReport
    from pendpin.verification.hardcases import Case, HardReport
    from pendpin.verification.work_precision.report import CostReport, CostRow


SHOWN = ("at rest from", "largest swing", "farthest sideways", "R3 largest")
LEAST_WIDTH = 60  # letters: on a narrower terminal the lines of a table go on below


def print_run(trajectory: "Trajectory", report: "CheckReport | None", files: list[Path], as_json: bool) -> None:
    """Counts and times of a run, its checks (energy, cross-check along the run), and the works."""
    from dataclasses import asdict

    from pendpin.model.model_of_run import as_written, leaving

    stats = trajectory.stats
    if as_json:
        drift = trajectory.energy().drift if stats.conservative else None
        checks: dict[str, Any] = {"energy_drift": drift, "crosscheck": report and report.worst.relative}
        if trajectory.work:
            checks["work"] = {kind: float(work[-1]) for kind, work in trajectory.work.items()}
            checks["energy_balance"] = trajectory.imbalance
        figures = {name: figure._asdict() for name, figure in trajectory.summary().items()}
        checks |= {"crosscheck_ok": report and report.ok, "summary": figures}
        checks |= {"joint_events": [event._asdict() for event in trajectory.events]}
        print_json(asdict(stats) | checks | {"files": [str(file) for file in files]})
        return
    estimate, total = (
        "no estimate" if stats.error is None else f"{stats.error:.1e} estimated",
        trajectory.energy().total,
    )
    rows = {
        "method": f"{stats.method}, {stats.setting} ({stats.library} {stats.version})",
        "accuracy": stats.accuracy and f"{estimate}, {stats.accuracy:g} asked",
        "engine": stats.engine,
        "as written": as_written(trajectory),
        "steps": str(stats.steps),
        "evaluations": str(stats.evaluations),
        "integrating": f"{stats.seconds:.4f} s"
        + (f", {stats.all_seconds:.4f} s with the runs before it" if stats.all_seconds else ""),
        "compiling": stats.compile_seconds and f"{stats.compile_seconds:.4f} s",
        "energy drift": f"{trajectory.energy().drift:.1e} of the energy exchanged" if stats.conservative else "",
        "energy change": "" if stats.conservative else f"{total[-1] - total[0]:+.6g} J",
        "cross-check": report and report.verdict,
        "note": "; ".join(stats.notes),
        "slid away": "\n".join(leaving(trajectory)),
    }
    rows |= _answers(trajectory) | {"files": ", ".join(str(file) for file in files)}
    rows |= {f"work of {kind}": f"{work[-1]:+.6g} J" for kind, work in trajectory.work.items()}
    if trajectory.work:
        rows["kinetic energy"] = f"{trajectory.kinetic[-1] - trajectory.kinetic[0]:+.6g} J"
        rows["energy balance is off by"] = f"{trajectory.imbalance:.1e} of the energy exchanged"
    print_table(["run", ""], [[name, text] for name, text in rows.items() if text])


def _answers(trajectory: "Trajectory") -> dict[str, str]:
    """How far a pendulum swings, later too if that is less, what it pulls, and when it comes to rest."""
    summary = trajectory.summary()
    answers = {name: str(summary[name]) for name in SHOWN if name in summary}
    for name in answers:
        later = summary.get(f"{name}, second half")
        if later and later.value < summary[name].value:
            answers[name] += f"; after half the time {later.value:.6g} {later.unit}"
    return answers | {"extremes": f"those of the {len(trajectory.t)} samples"}


def print_check(report: "CheckReport", every_row: bool, as_json: bool) -> None:
    """The matrix of a cross-check with its verdict; before it, where asked for, every pair of routes in every quantity."""
    from dataclasses import asdict

    if as_json:
        print_json(asdict(report) | {"ok": report.ok})
        return
    if every_row:
        rows = []
        for r in report.rows:
            figures = f"{r.relative:.1e}", f"{r.ulps:.1f}", str(r.state), _verdict(r.ok)
            rows.append([r.quantity, r.place, f"{r.first} / {r.second}", *figures])
        print_table(["quantity", "of", "routes", "relative", "ulps", "state", ""], rows)
    print(report.text())


def _verdict(ok: bool) -> str:
    return "ok" if ok else "BROKEN"


def print_effects(report: "EffectsReport", as_json: bool) -> None:
    """What each effect changes and costs."""
    from dataclasses import asdict

    if as_json:
        print_json(asdict(report))
        return
    rows = []
    for row in report.rows:
        change = f"{float(f'{100 * row.change:.2g}'):g} %"  # two digits, without an exponent
        added = "" if row.added is None else f"+{row.added:.0%}"
        rows.append([row.effect, "yes" if row.listed else "no", change, added, row.verdict])
    print_table(["effect", "in the scene", "moves a tip by", "time added", "verdict"], rows)
    print("A tip's largest distance with and without it, in per cent of the chain's length.")
    if any(not row.listed for row in report.rows):
        print("Effects that the scene lacks were tried with example numbers; yours may differ.")
    if report.horizon < report.duration:
        print(f"compared up to {report.horizon:.3g} s of {report.duration:g} s: {report.why}")


COST_WIDTHS = (8, 34, 9, 16, 30, 0)


def print_cost_row(row: "CostRow", peers: bool) -> None:
    """A line of the table of accuracies, at once; the coarsest accuracy brings the head."""
    from pendpin.verification.work_precision.report import ACCURACIES, time_text

    if row.accuracy >= max(ACCURACIES):
        head = ["accuracy", "fastest method", "first run", "each further run"]
        print(_aligned([*head, *(["best of the others"] if peers else []), "or, for a single run"]))
    times = ["" if seconds is None else time_text(seconds) for seconds in (row.first_seconds, row.seconds)]
    ratio = f", {row.ratio:.3g} x" if row.ratio else ""
    beside = row.peer and f"{row.peer} {time_text(row.peer_seconds or 0)}{ratio}"
    once = f"{row.once}: {time_text(row.once_seconds)}" if row.once_seconds else ""
    print(_aligned([f"{row.accuracy:g}", row.take, *times, *([beside] if peers else []), once]), flush=True)


def _aligned(cells: list[str]) -> str:
    return "  ".join(cell.ljust(width) for cell, width in zip(cells, COST_WIDTHS, strict=False)).rstrip()


def print_cost(report: "CostReport", as_json: bool) -> None:
    """What was found in sentences; where all was measured, the time of every method at some errors."""
    from dataclasses import asdict

    if as_json:
        print_json(asdict(report) | {"words": report.words})
        return
    if report.thorough:
        _print_methods(report)
    for sentence in report.words:
        print(sentence)
    least = f"Times of {report.horizon:g} s of the scene: the least of {report.repetitions} after a first"
    print(f"{report.machine}; {report.versions_text}. {least}; a first run counts its compiling, but no imports.")


def _print_methods(report: "CostReport") -> None:
    """The time of every method at some errors, and its run that meets the accuracy."""
    from pendpin.verification.work_precision.report import ACCURACIES, time_text

    errors = [error for error in ACCURACIES if error >= report.error]
    head = ["error:", *(f"{error:.0e}" for error in errors)]
    asked = [f"{report.accuracy:g} by", "steps", "evals"]
    rows = []
    for curve in report.curves:
        times = ["" if t is None else time_text(t) for t in map(curve.seconds_at, errors)]
        point, unit = curve.point_at(report.accuracy), " s" if curve.kind == "step" else ""
        figures = [f"{point.setting:.0e}{unit}", str(point.steps), str(point.evaluations)] if point else ["", "", ""]
        rows.append([curve.name, *times, *figures])
    print_table(head + asked, rows)
    for curve in report.curves:
        if curve.failures and not curve.points:
            print(f"{curve.name} failed: {curve.failures[-1]}")
    compiled = [f"{curve.name} {time_text(curve.compile_seconds)}" for curve in report.curves if curve.compile_seconds]
    if compiled:
        print(f"Compiling, on its own: {', '.join(compiled)}.")


def print_fit(fit: "Fit", as_json: bool) -> None:
    """Fitted numbers with their errors."""
    if as_json:
        print_json(fit.as_dict())
        return
    print_table(["", "value", "standard error"], [list(row) for row in fit.rows()])
    for line in fit.words():
        print(line)


def print_stability(stability: "Stability", as_json: bool) -> None:
    """The rests of a scene, or its periodic motion."""
    if not as_json:
        print(stability.text())
        return
    orbit = stability.orbit
    if orbit is None:
        print_json({"rests": stability.rows(), "notes": list(stability.notes)})
        return
    parts = [[float(x.real), float(x.imag)] for x in orbit.multipliers]
    print_json({"period": orbit.period, "multipliers": parts, "errors": orbit.errors.tolist(), "stable": orbit.stable})


def print_exponents(lyapunov: "Lyapunov", as_json: bool) -> None:
    """The Lyapunov exponents of a motion."""
    if not as_json:
        print(lyapunov.text())
        return
    print_json(
        {"exponents": lyapunov.exponents.tolist(), "error": lyapunov.error.tolist(), "duration": float(lyapunov.t[-1])}
    )


def print_modes(modes: "Modes", every: bool, as_json: bool) -> None:
    """The modes of a scene, the lowest ones or all."""
    from math import isfinite

    from pendpin.stability.modes import HEAD, MOST_ROWS

    if as_json:
        ratios = [x if isfinite(x) else None for x in modes.damping_ratio.tolist()]
        print_json({"omega": modes.omega.tolist(), "damping_ratio": ratios, "stable": modes.stable})
        return
    most = None if every else MOST_ROWS
    print_table(HEAD, [line.cells for line in modes.lines(most)])
    for line in modes.words(most):
        print(line)


def print_cases(cases: "list[Case]", as_json: bool) -> None:
    """The names of the hard cases, their titles and bounds."""
    if as_json:
        fields = ("name", "title", "figure", "bound")
        print_json([{name: getattr(case, name) for name in fields} for case in cases])
        return
    print_table(["case", "what", "bound"], [[case.name, case.title, f"{case.bound:.1e}"] for case in cases])


def print_measures(as_json: bool) -> None:
    """The measures of a sweep: name, unit, and what each is."""
    from pendpin.sweeps.measures import FAMILIES, MEASURES

    if as_json:
        print_json([{"measure": m.name, "unit": m.unit, "what": m.meaning} for m in MEASURES.values()])
        return
    print_table(["measure", "unit", "what"], [[m.name, m.unit, m.meaning] for m in MEASURES.values()])
    for line in FAMILIES:
        print(line)


def print_hard(report: "HardReport", as_json: bool) -> None:
    """The hard cases, what was measured of each on each method, and the claims that are broken."""
    if as_json:
        print_json(report.as_dict())
        return
    cases = ["", *(o.case for o in report.outcomes)]  # each named once
    rows = [
        ["" if o.case == before else o.case, o.method, o.shown, f"{o.bound:.1e}", o.verdict, f"{o.seconds:.2f}"]
        for before, o in zip(cases, report.outcomes, strict=False)
    ]
    print_table(["case", "method", "measured", "bound", "verdict", "seconds"], rows)
    for outcome in report.outcomes:
        if outcome.failure:
            print(f"{outcome.case} on {outcome.method}: {outcome.failure}")
    claims = [outcome for outcome in report.outcomes if outcome.claimed]
    if claims:
        print(f"{len(claims)} claims, {len(report.broken)} broken, {sum(o.seconds for o in claims):.0f} s")


def print_agreement(report: "AgreementReport", as_json: bool) -> None:
    """Of each published quantity the method that differs most; what was left out; the counts."""
    if as_json:
        print_json(report.to_json())
        return
    cases = [row.case for row in report.worst]
    rows = [
        [
            "" if i and r.case == cases[i - 1] else r.case,
            r.quantity,
            f"{r.bound:.0e} {r.unit}",
            r.shown,
            r.method,
            _verdict(r.ok),
        ]
        for i, r in enumerate(report.worst)
    ]
    print_table(["case", "quantity", "bound", "largest difference", "by", ""], rows)
    for row in report.comparisons:
        if row.failure:
            print(f"{row.case} by {row.method}: {row.failure}")
    for line in report.left_out:
        print(f"left out: {line}")
    print(f"{len(report.comparisons)} comparisons, {len(report.broken)} beyond their bounds")


def print_published(cases: "dict[str, Published]", as_json: bool) -> None:
    """The published cases with what they compare and where the numbers come from."""
    if as_json:
        print_json([{"case": name} | case.model_dump(mode="json") for name, case in cases.items()])
        return
    rows = [[name, case.title, case.origin, case.source] for name, case in cases.items()]
    print_table(["case", "motion", "numbers by", "source"], rows)


def print_table(head: list[str], rows: list[list[str]]) -> None:
    """A table on the terminal: the first column has names, and the others give way to it; no letter is cut."""
    from rich.console import Console
    from rich.table import Column, Table
    from rich.text import Text

    columns = [Column(title, overflow="fold", no_wrap=i == 0) for i, title in enumerate(head)]
    table = Table(*columns, show_header=any(head[1:]))
    for row in rows:
        table.add_row(*map(Text, row))  # no markup in what users named
    console = Console()
    console.width = max(console.width, LEAST_WIDTH)
    console.print(table)


def print_json(value: Any) -> None:
    """JSON on the terminal."""
    from json import dumps

    print(dumps(value, indent=2, default=str))


def print_files(files: list[Path], as_json: bool = False) -> None:
    """The files written, a line each; none beside JSON."""
    for file in () if as_json else files:
        print(f"wrote {file}")


def print_diagnosis(diagnosis: "Diagnosis", as_json: bool) -> None:
    """Every equation with its verdict, how it fails, and what corrects it."""
    if as_json:
        print_json(diagnosis.to_json())
        return
    from rich.console import Console
    from rich.text import Text

    from pendpin.doctor.reports.text import lines

    console = Console()
    for line in lines(diagnosis):
        console.print(Text.assemble(*line), soft_wrap=True)
