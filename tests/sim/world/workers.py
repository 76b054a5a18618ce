# SPDX-License-Identifier: Apache-2.0
"""What a worker of a Dask cluster must be: of the same build as the campaign."""

from __future__ import annotations

from typing import Any

from distributed import WorkerPlugin

from campaign import BINARY, build_of


class SameBuild(WorkerPlugin):  # type: ignore[misc]  # distributed has no types
    """Refuses a worker whose light is another build."""

    name = "same-build"

    def __init__(self, build: str) -> None:
        self.build = build

    def setup(self, worker: Any) -> None:
        here = build_of() if BINARY.exists() else "none"
        if here != self.build:
            # one that joins later would stay, and work, though its plugin has failed
            worker.loop.add_callback(worker.close, nanny=True, reason="another build")
            raise RuntimeError(
                f"{worker.address} has another build ({here[:12]}) than the campaign "
                f"({self.build[:12]}): build the same commit there"
            )
