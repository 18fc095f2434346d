"""The report of a study: a page with the Pareto front, the best trials and parallel coordinates."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path

from .. import __version__, _sinew
from ._journal import Trial
from ._study import Study

#: Rows of the table of best trials.
ROWS = 20
STYLE = """
.plot { background: var(--card); border: 1px solid var(--line); border-radius: 12px; width: 100%; height: auto; }
.plot text { fill: var(--soft); font: 12px system-ui, sans-serif; }
.plot line { stroke: var(--rule); }
.plot polyline { fill: none; stroke: var(--rule); stroke-opacity: 0.35; }
.plot polyline.best { stroke: var(--accent); stroke-opacity: 0.9; stroke-width: 1.5; }
.plot circle { fill: var(--rule); fill-opacity: 0.6; }
.plot circle.best { fill: var(--accent); fill-opacity: 1; }
.shell { display: block; max-width: 64rem; }
"""
MARK = (
    '<svg viewBox="0 0 24 24" width="20" height="20" aria-hidden="true"><path d="M3 18C8 18 8 6 13 6h8M3 13c4 0 5-7 9-7" '
    'fill="none" stroke="currentColor" stroke-width="2" stroke-linecap="round"/></svg>'
)


def pareto_front(trials: Sequence[Trial], minimize: Sequence[str], maximize: Sequence[str] = ()) -> list[Trial]:
    """Trials than which no other is at least as good in all values and better in one."""
    ended = [t for t in trials if t.ended and t.error is None]
    signs = [(name, 1.0) for name in minimize] + [(name, -1.0) for name in maximize]
    rows = [tuple(sign * t.values[name] for name, sign in signs) for t in ended]
    # In ascending order a trial can only be dominated by one before it that is on the front itself.
    front: list[int] = []
    for k in sorted(range(len(rows)), key=rows.__getitem__):
        row = rows[k]
        if not any(rows[j] != row and all(b <= a for a, b in zip(row, rows[j], strict=True)) for j in front):
            front.append(k)
    return [ended[k] for k in sorted(front)]


def write_report(study: Study, path: str | os.PathLike[str]) -> None:
    """Writes the report as one HTML file without links to others."""
    trials = [t for t in study.trials if t.ended and t.error is None]
    failed = [t for t in study.trials if t.error is not None]
    desired = [*study.minimize, *study.maximize]
    names = [("parameter", name) for name in study.parameters]
    names += [("value", name) for name in (desired or sorted({k for t in trials for k in t.values}))]
    best = {t.number for t in pareto_front(trials, study.minimize, study.maximize)} if desired else set()
    goals = [f"least {name}" for name in study.minimize] + [f"largest {name}" for name in study.maximize]
    body = f"<section class=hero><h1>Study of {len(study.trials)} trials</h1>"
    body += f"<p class=lead>{escape('; '.join(goals) or 'no value is optimised')}; seed {study.seed}.</p>"
    figures = [("trials that ended", len(trials)), ("with an error", len(failed))]
    if desired:
        figures.append(("on the Pareto front" if len(desired) > 1 else "best", len(best)))
    body += "<dl class=figures>" + "".join(f"<div><dd>{n}</dd><dt>{name}</dt></div>" for name, n in figures)
    body += "</dl></section>"
    if len(desired) >= 2 and trials:
        body += "<section><h2>Pareto front</h2>" + _scatter(trials, desired[0], desired[1], best) + "</section>"
    if names and trials:
        body += "<section><h2>Parallel coordinates</h2>" + _parallel(trials, names, best) + "</section>"
    if best:
        body += "<section><h2>Best trials</h2>" + _table([t for t in trials if t.number in best], names) + "</section>"
    if failed:
        first = "".join(f"<li>trial {t.number}: {escape(str(t.error))}</li>" for t in failed[:ROWS])
        body += f"<section><div class=warnings><h2>Trials with an error</h2><ul>{first}</ul></div></section>"
    versions = {f"{name} {version}" for t in study.trials for name, version in t.versions.items()}
    body += f"<section><p class=note>Computed with {escape(', '.join(sorted(versions)))}.</p></section>"
    # Objectives of this package compute on models of machines; of others nothing is known.
    simulated = getattr(study.objective, "simulated", False)
    tag = '<span class="tag warn">simulated data</span>' if simulated else ""
    page = (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8"><meta name="viewport" '
        'content="width=device-width, initial-scale=1"><meta name="color-scheme" content="light dark">'
        f'<meta name="generator" content="sinew {__version__}"><title>Study</title>'
        f"<style>{_sinew.page_style()}{STYLE}</style></head><body>"
        f'<header class="bar"><span class="brand">{MARK}Sinew</span><span class="muted">study</span>{tag}</header>'
        f'<div class="shell"><main>{body}</main></div></body></html>\n'
    )
    part = Path(f"{os.fspath(path)}.part")
    part.write_text(page, encoding="utf-8")
    part.replace(path)


def _table(trials: list[Trial], names: list[tuple[str, str]]) -> str:
    head = "".join(f"<th class=number>{escape(name)}</th>" for _, name in names)
    rows = "".join(
        f"<tr><th>{t.number}</th>" + "".join(f"<td class=number>{_of(t, *name):.4g}</td>" for name in names) + "</tr>"
        for t in trials[:ROWS]
    )
    more = f"<p class=note>{len(trials) - ROWS} more in the table of results.</p>" if len(trials) > ROWS else ""
    return f"<div class=table><table><thead><tr><th>trial</th>{head}</tr></thead><tbody>{rows}</tbody></table></div>{more}"


def _of(trial: Trial, kind: str, name: str) -> float:
    return (trial.parameters if kind == "parameter" else trial.values).get(name, float("nan"))


def _share(values: list[float]) -> list[float]:
    low, high = min(values), max(values)
    return [0.5 if high == low else (value - low) / (high - low) for value in values]


def _mark(trial: Trial, best: set[int]) -> str:
    return ' class="best"' if trial.number in best else ""


def _scatter(trials: list[Trial], across: str, up: str, best: set[int]) -> str:
    horizontal, vertical = ([t.values[name] for t in trials] for name in (across, up))
    # The best are drawn last, on top.
    places = sorted(zip(trials, _share(horizontal), _share(vertical), strict=True), key=lambda p: p[0].number in best)
    dots = "".join(
        f'<circle cx="{80 + 690 * a:.1f}" cy="{330 - 300 * b:.1f}" r="4"{_mark(t, best)}>'
        f"<title>trial {t.number}: {escape(across)} {t.values[across]:.4g}, {escape(up)} {t.values[up]:.4g}</title></circle>"
        for t, a, b in places
    )
    texts = [
        (80, 352, "start", f"{min(horizontal):.4g}"),
        (770, 352, "end", f"{max(horizontal):.4g}"),
        (425, 370, "middle", across),
        (70, 334, "end", f"{min(vertical):.4g}"),
        (70, 34, "end", f"{max(vertical):.4g}"),
        (80, 18, "start", up),
    ]
    return f'<svg class="plot" viewBox="0 0 800 380" role="img">{_texts(texts)}{dots}</svg>'


def _texts(texts: Sequence[tuple[float, float, str, str]]) -> str:
    return "".join(f'<text x="{x:.1f}" y="{y}" text-anchor="{side}">{escape(text)}</text>' for x, y, side, text in texts)


def _parallel(trials: list[Trial], names: list[tuple[str, str]], best: set[int]) -> str:
    trials = [t for t in trials if all(kind == "parameter" or name in t.values for kind, name in names)]
    if not trials:
        return "<p>No trial has all values.</p>"
    trials.sort(key=lambda t: t.number in best)
    columns = [[_of(t, *name) for t in trials] for name in names]
    fractions = [_share(column) for column in columns]
    places = [80 + 640 * k / max(1, len(names) - 1) for k in range(len(names))]
    lines = ""
    for k, trial in enumerate(trials):
        points = " ".join(f"{x:.1f},{330 - 270 * s[k]:.1f}" for x, s in zip(places, fractions, strict=True))
        lines += f'<polyline points="{points}"{_mark(trial, best)}/>'
    for k, (x, (_, name), column) in enumerate(zip(places, names, columns, strict=True)):
        # Names at two heights, so that long ones do not meet.
        texts = [(x, 16 + 16 * (k % 2), name), (x, 52, f"{max(column):.4g}"), (x, 348, f"{min(column):.4g}")]
        lines += f'<line x1="{x:.1f}" y1="60" x2="{x:.1f}" y2="330"/>'
        lines += _texts([(x, y, "middle", text) for x, y, text in texts])
    return f'<svg class="plot" viewBox="0 0 800 360" role="img">{lines}</svg>'
