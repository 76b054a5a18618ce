# SPDX-License-Identifier: Apache-2.0
"""docs/api.md: what the docstrings say, and examples that run."""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Callable
from pathlib import Path

import pytest

import pharos
from pharos.api_page import GROUPS, page
from real_light import RealLight

PAGE = Path(__file__).resolve().parents[2] / "docs" / "api.md"
EXAMPLES = re.findall(r"```python\n(.*?)```", page(), re.DOTALL)


def test_the_page_is_what_the_docstrings_say() -> None:
    assert PAGE.read_text() == page(), "python -m pharos.api_page > docs/api.md"


def test_every_public_name_is_on_it() -> None:
    shown = [name for names in GROUPS.values() for name in names]
    assert sorted(shown) == sorted(pharos.__all__)


@pytest.mark.realtime
@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_its_examples_run(real_light: Callable[..., RealLight], number: int) -> None:
    url = real_light("--uart0", "udpin:127.0.0.1:0").url()
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(EXAMPLES[number].replace("udp:127.0.0.1:14550", url), {})
    expected = ("on, 100 %, strobe 0.5 s at 10 %", url, "True must: 6 passed")
    assert out.getvalue().startswith(expected[number])
