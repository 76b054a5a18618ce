# SPDX-License-Identifier: Apache-2.0
"""The illuminator protocol as an executable specification, for the lights of any maker."""

from __future__ import annotations

# The order of these is that in which their requirements run.
from . import presence  # isort: skip
from . import information  # isort: skip
from . import lamp  # isort: skip
from . import commands  # isort: skip
from . import intervals  # isort: skip
from . import framing  # isort: skip
from . import parameters  # isort: skip
from . import files  # isort: skip
from . import gimbal  # isort: skip
from . import signing  # isort: skip
from . import optics  # isort: skip
from .report import as_html, as_junit, as_object, as_page
from .run import Report, Result, check, find, selected
from .spec import REQUIREMENTS, Level, Requirement, requirements_of

__all__ = [
    "REQUIREMENTS",
    "Level",
    "Report",
    "Requirement",
    "Result",
    "as_html",
    "as_junit",
    "as_object",
    "as_page",
    "check",
    "commands",
    "files",
    "find",
    "framing",
    "gimbal",
    "information",
    "intervals",
    "lamp",
    "optics",
    "parameters",
    "presence",
    "requirements_of",
    "selected",
    "signing",
]
