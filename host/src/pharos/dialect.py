# SPDX-License-Identifier: Apache-2.0
"""The MAVLink dialect: pymavlink's common.xml and what the project adds to it.

It is looked for in this order: the path given; $PHAROS_DIALECT; a module `pharos_dialect` on the
Python path; a cache folder, into which it is generated once (about a second) from the definitions
that come with this package.
"""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import os
import shutil
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path
from typing import Any

from .errors import DialectError

MODULE = "pharos_dialect"
DEFINITIONS = Path(__file__).parent / "mavlink" / "pharos.xml"


def load_dialect(path: str | os.PathLike[str] | None = None) -> Any:
    """The generated module. DialectError when there is none or it lacks the illuminator."""
    chosen = path or os.environ.get("PHAROS_DIALECT")
    if chosen:
        module = _load_file(Path(chosen))
    elif MODULE in sys.modules or importlib.util.find_spec(MODULE):
        module = importlib.import_module(MODULE)
    else:
        module = _load_file(generated_dialect())
    for name in ("MAVLINK_MSG_ID_ILLUMINATOR_STATUS", "MAVLINK_MSG_ID_COMPONENT_INFORMATION_BASIC"):
        if not hasattr(module, name):
            raise DialectError(f"{module.__file__}: lacks {name}; generate it from pharos.xml")
    return module


def find_dialect(build: str | os.PathLike[str]) -> Path:
    """The generated dialect's file in a build folder."""
    found = sorted(Path(build).rglob(f"{MODULE}.py"))
    if not found:
        raise DialectError(f"no {MODULE}.py below {build}: run `make build`")
    return found[0]


def generated_dialect(cache: Path | None = None) -> Path:
    """The dialect's file in the cache folder, generated if it is not there yet."""
    folder = (cache or _cache_folder()) / _key()
    path = folder / f"{MODULE}.py"
    if path.is_file():
        return path
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as scratch:
            fresh = _generate(Path(scratch))
            # Whoever generates at the same time writes the same file.
            os.replace(fresh, path)
    except OSError as error:
        raise DialectError(f"{folder}: {error.strerror}; set XDG_CACHE_HOME") from error
    return path


def _cache_folder() -> Path:
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "pharos"


def _key() -> str:
    """Changes with everything that the result depends on."""
    digest = hashlib.sha256(version("pymavlink").encode())
    for path in (DEFINITIONS, DEFINITIONS.with_name("generate.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _generate(scratch: Path) -> Path:
    from .mavlink import generate

    try:
        wheel, _ = generate.wheel_definitions()
        staged, _ = generate.stage(DEFINITIONS, wheel, scratch / "xml")
        generate.check(generate.parse_messages(generate.with_includes(staged)))
        generate.run_mavgen(staged, scratch / f"{MODULE}.py", "Python3")
    except generate.GenerateError as error:
        raise DialectError(f"the MAVLink dialect: {error}") from error
    shutil.rmtree(scratch / "xml")
    return scratch / f"{MODULE}.py"


def _load_file(path: Path) -> Any:
    # pymavlink-style modules are found by name elsewhere too, so one file is loaded once.
    loaded = sys.modules.get(MODULE)
    if loaded is not None and getattr(loaded, "__file__", None) == str(path):
        return loaded
    spec = importlib.util.spec_from_file_location(MODULE, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise DialectError(f"{path}: no generated MAVLink dialect there; run `make build`")
    module = importlib.util.module_from_spec(spec)
    sys.modules[MODULE] = module
    spec.loader.exec_module(module)
    return module
