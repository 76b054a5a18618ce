# SPDX-License-Identifier: Apache-2.0
"""A report as JSON, JUnit's XML, and one HTML page. What a device said stands in it as text."""

from __future__ import annotations

import time
from typing import Any
from xml.etree import ElementTree

from jinja2 import Environment

from ..text import printable
from .run import FAILED, NOT_RUN, SKIPPED, Report, Result
from .spec import GROUPS, PROFILES, Level, Requirement, requirements_of


def as_fields(result: Result) -> dict[str, Any]:
    requirement = result.requirement
    return {
        "id": requirement.id,
        "level": requirement.level.value,
        "title": requirement.title,
        "clause": requirement.clause,
        "url": requirement.url,
        "outcome": result.outcome,
        "seen": result.seen,
        "seconds": round(result.seconds, 3),
        "log": list(result.log),
    }


def as_object(report: Report) -> dict[str, Any]:
    return {
        "link": report.link,
        "device": report.device,
        "system": report.target.system if report.target else None,
        "component": report.target.component if report.target else None,
        "maker": report.maker,
        "time": when(report),
        "passed": report.passed,
        "summary": report.summary(),
        "left": report.left,
        "results": [as_fields(result) for result in report.results],
    }


def when(report: Report) -> str:
    return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(report.started))


def as_junit(report: Report) -> str:
    """A test case for each requirement. A should that fails is no failure there, but is told."""
    suite = ElementTree.Element(
        "testsuite",
        name="pharos check",
        tests=str(len(report.results)),
        failures=str(len(report.broken())),
        errors="1" if report.left else "0",
        skipped=str(report.count(SKIPPED) + report.count(NOT_RUN)),
        time=f"{sum(r.seconds for r in report.results):.3f}",
        timestamp=when(report).removesuffix("Z"),
    )
    for result in report.results:
        requirement = result.requirement
        case = ElementTree.SubElement(
            suite,
            "testcase",
            classname=f"check.{requirement.group}",
            name=f"{requirement.id} {requirement.level.value}: {requirement.title}",
            time=f"{result.seconds:.3f}",
        )
        log = "\n".join(map(printable, [requirement.clause, requirement.url, *result.log]))
        if result.breaks:
            failure = ElementTree.SubElement(case, "failure", message=printable(result.seen))
            failure.text = log
        elif result.outcome in (SKIPPED, NOT_RUN):
            ElementTree.SubElement(case, "skipped", message=printable(result.seen))
        elif result.outcome == FAILED:
            out = ElementTree.SubElement(case, "system-out")
            out.text = f"{requirement.level.value} fails: {printable(result.seen)}\n{log}"
    if report.left:
        case = ElementTree.SubElement(suite, "testcase", classname="check", name="left as it was")
        ElementTree.SubElement(case, "error", message=printable(report.left))
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"


PAGE = """\
<!doctype html>
<html lang="en"><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>pharos check: {{ maker or link }}</title>
<style>
:root { color-scheme: light dark; --line: #8884; --good: #2a7f3f; --bad: #c2362b; --weak: #a06800;
  --link: #2058b0; }
@media (prefers-color-scheme: dark) {
  :root { --good: #63c27c; --bad: #ff8577; --weak: #e0a63c; --link: #8ab4f8; }
}
body { font: 15px/1.45 system-ui, sans-serif; max-width: 60rem; margin: 1.5rem auto;
  padding: 0 1rem; overflow-wrap: anywhere; }
h1 { font-size: 1.5rem; margin: 0; } h2 { font-size: 1.1rem; margin: 2rem 0 .5rem; }
p { margin: .4rem 0; } a { color: var(--link); text-decoration: none; }
a:hover { text-decoration: underline; } small { opacity: .7; }
.verdict { font-weight: 600; } .passed { color: var(--good); } .broken { color: var(--bad); }
.weak { color: var(--weak); } .none { opacity: .6; }
table { border-collapse: collapse; width: 100%; table-layout: fixed; }
td { border-top: 1px solid var(--line); padding: .35rem .25rem; vertical-align: top; }
td:first-child { width: 4.2rem; } td:first-child small { display: block; }
td:last-child { width: 5.6rem; text-align: right; }
tr:target { background: var(--line); }
pre { font-size: 12px; line-height: 1.35; white-space: pre-wrap; margin: .4rem 0; }
pre span { display: block; padding-left: 12ch; text-indent: -12ch; }
summary { cursor: pointer; } details > *, .seen { padding-left: 1rem; }
summary { padding: 0; } .seen { font-weight: 600; }
@media (max-width: 40rem) {
  tr { display: grid; grid-template: auto 1fr / 4.6rem 1fr; border-top: 1px solid var(--line); }
  td, td:first-child, td:last-child { border: 0; width: auto; text-align: left; }
  td:nth-child(2) { grid-row: span 2; }
  td:last-child { padding-top: 0; font-size: 13px; }
  details > *, .seen { padding-left: 0; }
  pre { font-size: 11px; } pre span { padding-left: 2ch; text-indent: -2ch; }
}
</style>
<h1>{{ maker or "A light" }}</h1>
<p><small>{{ target }} at {{ link }}, {{ time }}</small></p>
<p class="verdict {{ "passed" if passed else "broken" }}">{{ summary }}</p>
{% if left %}<p class="verdict broken">{{ left }}</p>{% endif %}
{% if failed %}<p>{% for r in failed %}<a class="{{ r.class }}" href="#{{ r.id }}">{{ r.id }}</a>{{
" " }}{% endfor %}</p>{% endif %}
{% for title, results in groups %}
<h2>{{ title }}</h2>
<table>
{% for r in results %}
<tr id="{{ r.id }}"><td><a href="{{ r.url }}">{{ r.id }}</a><small>{{ r.level }}</small></td>
<td><details{% if r.outcome == "failed" %} open{% endif %}><summary>{{ r.title }}</summary>
<p>{{ r.explanation }}</p><p><a href="{{ r.url }}">{{ r.clause }}</a></p>
{% if r.log %}<pre>{% for line in r.log %}<span>{{ line }}</span>{% endfor %}</pre>{% endif %}
</details>
{% if r.seen %}<p class="seen {{ r.class }}">{{ r.seen }}</p>{% endif %}</td>
<td class="{{ r.class }}">{{ r.outcome }}</td></tr>
{% endfor %}
</table>
{% endfor %}
</html>
"""


def as_html(report: Report) -> str:
    """One page, with nothing to load."""
    groups = []
    for prefix, title in GROUPS.items():
        rows = [_row(r) for r in report.results if r.requirement.group == prefix]
        if rows:
            groups.append((title, rows))
    page = Environment(autoescape=True, trim_blocks=True).from_string(PAGE)
    return page.render(
        maker=printable(report.maker),
        link=printable(report.link),
        target=report.device,
        time=when(report),
        passed=report.passed,
        summary=report.summary(),
        left=printable(report.left),
        failed=[_row(r) for r in report.results if r.outcome == FAILED],
        groups=groups,
    )


def _row(result: Result) -> dict[str, Any]:
    fields = as_fields(result)
    if result.outcome == FAILED:
        kind = "broken" if result.breaks else "weak"
    else:
        kind = "none" if result.outcome in (SKIPPED, NOT_RUN) else "passed"
    return fields | {
        "seen": printable(result.seen),
        "log": [printable(line) for line in result.log],
        "explanation": result.requirement.explanation,
        "class": kind,
    }


def as_page() -> str:
    """The requirements as a page of the documentation."""
    mavlink, dronecan, imc = (requirements_of(name) for name in PROFILES)
    lines = [
        "# What `pharos check` asks of a light",
        "",
        f"Made from the code by `pharos check --list --markdown`. {_counted(mavlink)}.",
        "",
        "The requirements are those of the MAVLink guide and of common.xml, for an illuminator of",
        "any maker; the clause is linked. A light passes if no must fails. What it does not offer",
        "(parameters, files, a gimbal, a key) is not asked of it. While it is looked at, the lamp",
        "is on at 5 % at most, and in the end it is off, with its settings as they were; no",
        "parameter, file or key is changed.",
        "",
        "Two more profiles are at the end: `--profile dronecan`, which asks of a node what the",
        f"DroneCAN specification says ({_counted(dronecan)}), and `--profile imc`",
        f"({_counted(imc)}). How a light is commanded is no standard in either, but for a",
        "hardpoint and an LED of a name; they are off in the end.",
    ]
    for rows in (mavlink, dronecan, imc):
        for prefix in dict.fromkeys(r.group for r in rows):
            lines += _table(prefix, [r for r in rows if r.group == prefix])
    return "\n".join(lines) + "\n"


def _counted(rows: list[Requirement]) -> str:
    counts = {level.value: sum(r.level == level for r in rows) for level in Level}
    shown = ((f"{n} {name}{'s' if n > 1 else ''}") for name, n in counts.items() if n)
    return ", ".join(shown)


def _table(prefix: str, rows: list[Requirement]) -> list[str]:
    lines = ["", f"## {GROUPS[prefix]}", "", "| | | the light … | what is sent and looked at |"]
    lines += ["|---|---|---|---|"]
    for r in rows:
        why = " ".join(r.explanation.split()).replace("|", "\\|")
        clause = f"[{r.clause}]({r.url})"
        lines.append(f"| {r.id} | {r.level.value} | {r.title} | {why} {clause} |")
    return lines
