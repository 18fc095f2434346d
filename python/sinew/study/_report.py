"""The report of a study: a page with the Pareto front and parallel coordinates."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path

from ._journal import Trial
from ._study import Study


def pareto_front(trials: Sequence[Trial], minimize: Sequence[str]) -> list[Trial]:
    """Trials than which no other is at least as good in all values and better in one."""
    ended = [t for t in trials if t.ended and t.error is None]
    rows = [tuple(t.values[name] for name in minimize) for t in ended]

    def worse(row: tuple[float, ...], other: tuple[float, ...]) -> bool:
        return row != other and all(b <= a for a, b in zip(row, other, strict=True))

    return [t for t, row in zip(ended, rows, strict=True) if not any(worse(row, other) for other in rows)]


def write_report(study: Study, path: str | os.PathLike[str]) -> None:
    """Writes the report as one HTML file without links to others."""
    trials = [t for t in study.trials if t.ended and t.error is None]
    failed = sum(t.error is not None for t in study.trials)
    names = [("parameter", name) for name in study.parameters]
    names += [("value", name) for name in (study.minimize or sorted({k for t in trials for k in t.values}))]
    front = {t.number for t in pareto_front(trials, study.minimize)} if study.minimize else set()
    body = f"<h1>Study</h1><p>{len(trials)} trials, {failed} with an error, seed {study.seed}.</p>"
    if len(study.minimize) >= 2:
        body += "<h2>Pareto front</h2>" + _scatter(trials, study.minimize[0], study.minimize[1], front)
    if names and trials:
        body += "<h2>Parallel coordinates</h2>" + _parallel(trials, names, front)
    style = "body{font:15px system-ui;max-width:60rem;margin:2rem auto}svg{width:100%;background:#f6f6f4}"
    page = f"<!doctype html><html lang=en><meta charset=utf-8><title>Study</title><style>{style}</style>{body}</html>\n"
    part = Path(f"{os.fspath(path)}.part")
    part.write_text(page, encoding="utf-8")
    part.replace(path)


def _share(values: list[float]) -> list[float]:
    low, high = min(values), max(values)
    return [0.5 if high == low else (value - low) / (high - low) for value in values]


def _scatter(trials: list[Trial], across: str, up: str, front: set[int]) -> str:
    x, y = (_share([t.values[name] for t in trials]) for name in (across, up))
    dots = "".join(
        f'<circle cx="{60 + 680 * a:.1f}" cy="{350 - 320 * b:.1f}" r="4" fill="{_colour(t, front)}"/>'
        for t, a, b in zip(trials, x, y, strict=True)
    )
    limits = f"{escape(across)} across, {escape(up)} up; each over the range that occurs"
    return f'<svg viewBox="0 0 800 380">{dots}</svg><p>{limits}; blue: the front.</p>'


def _parallel(trials: list[Trial], names: list[tuple[str, str]], front: set[int]) -> str:
    def of(trial: Trial, kind: str, name: str) -> float:
        return (trial.parameters if kind == "parameter" else trial.values)[name]

    trials = [t for t in trials if all(kind == "parameter" or name in t.values for kind, name in names)]
    if not trials:
        return "<p>No trial has all values.</p>"
    columns = [[of(t, *name) for t in trials] for name in names]
    shares = [_share(column) for column in columns]
    places = [60 + 680 * k / max(1, len(names) - 1) for k in range(len(names))]
    lines = ""
    for k, trial in enumerate(trials):
        points = " ".join(f"{x:.1f},{330 - 280 * s[k]:.1f}" for x, s in zip(places, shares, strict=True))
        lines += f'<polyline points="{points}" fill="none" stroke="{_colour(trial, front)}" stroke-opacity=".6"/>'
    for x, (_, name), column in zip(places, names, columns, strict=True):
        texts = ((30, escape(name)), (46, f"{max(column):.4g}"), (346, f"{min(column):.4g}"))
        lines += f'<line x1="{x}" y1="50" x2="{x}" y2="330" stroke="#333"/>'
        lines += "".join(f'<text x="{x}" y="{y}" font-size="12" text-anchor="middle">{t}</text>' for y, t in texts)
    return f'<svg viewBox="0 0 800 360">{lines}</svg>'


def _colour(trial: Trial, front: set[int]) -> str:
    return "#1f6fb4" if trial.number in front else "#999"
