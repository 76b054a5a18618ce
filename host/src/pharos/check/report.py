# SPDX-License-Identifier: Apache-2.0
"""A report as JSON, JUnit's XML, and one HTML page. What a device said stands in it as text."""

from __future__ import annotations

import time
from typing import Any
from xml.etree import ElementTree

from jinja2 import Environment

from ..text import printable
from .run import FAILED, NOT_RUN, SKIPPED, Report, Result
from .spec import GROUPS, REQUIREMENTS, Level


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
        "system": report.target.system,
        "component": report.target.component,
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
:root { color-scheme: light dark; --line: #8884; --good: #2a7f3f; --bad: #c2362b; --weak: #b07400; }
body { font: 15px/1.45 system-ui, sans-serif; max-width: 62rem; margin: 2rem auto;
  padding: 0 1rem; }
h1 { font-size: 1.5rem; margin: 0; } h2 { font-size: 1.1rem; margin: 2rem 0 .5rem; }
.verdict { font-weight: 600; } .passed { color: var(--good); } .broken { color: var(--bad); }
.weak { color: var(--weak); } .none { opacity: .6; }
table { border-collapse: collapse; width: 100%; }
td { border-top: 1px solid var(--line); padding: .35rem .5rem; vertical-align: top; }
td:first-child, td:nth-child(2) { white-space: nowrap; }
pre { font-size: 12px; overflow-x: auto; margin: .4rem 0; } summary { cursor: pointer; }
.seen { font-weight: 600; }
</style>
<h1>{{ maker or "A light" }}</h1>
<p>{{ target }} at {{ link }}, {{ time }}</p>
<p class="verdict {{ "passed" if passed else "broken" }}">{{ summary }}</p>
{% if left %}<p class="verdict broken">{{ left }}</p>{% endif %}
{% for title, results in groups %}
<h2>{{ title }}</h2>
<table>
{% for r in results %}
<tr><td><a href="{{ r.url }}">{{ r.id }}</a></td><td>{{ r.level }}</td>
<td><details{% if r.outcome == "failed" %} open{% endif %}><summary>{{ r.title }}</summary>
<p>{{ r.explanation }}</p><p>{{ r.clause }}</p>
{% if r.log %}<pre>{% for line in r.log %}{{ line }}
{% endfor %}</pre>{% endif %}</details>
{% if r.seen %}<span class="seen">{{ r.seen }}</span>{% endif %}</td>
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
        target=f"component {report.target.system}/{report.target.component}",
        time=when(report),
        passed=report.passed,
        summary=report.summary(),
        left=printable(report.left),
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
    counts = [sum(r.level == level for r in REQUIREMENTS) for level in Level]
    lines = [
        "# What `pharos check` asks of a light",
        "",
        "Made from the code by `pharos check --list --markdown`. "
        f"{counts[0]} musts, {counts[1]} shoulds, {counts[2]} may.",
        "",
        "The requirements are those of the MAVLink guide and of common.xml, for an illuminator of",
        "any maker; the clause is linked. A light passes if no must fails. What it does not offer",
        "(parameters, files, a gimbal, a key) is not asked of it. While it is looked at, the lamp",
        "is on at 5 % at most, and in the end it is off, with its settings as they were; no",
        "parameter, file or key is changed.",
    ]
    for prefix, title in GROUPS.items():
        lines += ["", f"## {title}", "", "| | | the light … | what is sent and looked at |"]
        lines += ["|---|---|---|---|"]
        for r in REQUIREMENTS:
            if r.group == prefix:
                why = " ".join(r.explanation.split()).replace("|", "\\|")
                clause = f"[{r.clause}]({r.url})"
                lines.append(f"| {r.id} | {r.level.value} | {r.title} | {why} {clause} |")
    return "\n".join(lines) + "\n"
