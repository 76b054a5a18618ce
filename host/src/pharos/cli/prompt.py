# SPDX-License-Identifier: Apache-2.0
"""The interactive prompt: completion, history, and the light's live status at the bottom."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from prompt_toolkit import PromptSession
from prompt_toolkit.application import get_app
from prompt_toolkit.auto_suggest import AutoSuggestFromHistory
from prompt_toolkit.completion import CompleteEvent, Completer, Completion
from prompt_toolkit.document import Document
from prompt_toolkit.history import FileHistory, History, InMemoryHistory
from prompt_toolkit.patch_stdout import patch_stdout

from ..errors import PharosError
from .shell import COMMANDS, OK, Shell

# How often the light is heard while nobody types [s].
POLL_S = 0.1
# The toolbar says so when the light has said nothing for this long [µs].
SILENCE_US = 3_000_000


class CommandCompleter(Completer):
    def get_completions(
        self, document: Document, complete_event: CompleteEvent
    ) -> Iterable[Completion]:
        before = document.text_before_cursor.rpartition(";")[2].lstrip()
        words = before.split(" ")
        if len(words) == 1:
            for command in COMMANDS.values():
                if command.name.startswith(words[0]):
                    yield Completion(
                        command.name, start_position=-len(words[0]), display_meta=command.help
                    )
            return
        known = COMMANDS.get(words[0])
        choices = tuple(COMMANDS) if words[0] == "help" else known.words if known else ()
        if len(words) == 2:
            for word in choices:
                if word.startswith(words[1]):
                    yield Completion(word, start_position=-len(words[1]))


def history_path() -> Path:
    base = os.environ.get("XDG_STATE_HOME")
    return (Path(base) if base else Path.home() / ".local" / "state") / "pharos" / "history"


def open_history() -> History:
    path = history_path()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    except OSError:
        return InMemoryHistory()  # a home that cannot be written to is no reason not to work
    return FileHistory(str(path))


class Prompt:
    """Reads lines from a terminal and runs them until quit or Ctrl-D."""

    def __init__(self, shell: Shell) -> None:
        self._shell = shell
        self._session: PromptSession[str] = PromptSession(
            history=open_history(),
            completer=CommandCompleter(),
            auto_suggest=AutoSuggestFromHistory(),
            bottom_toolbar=self.toolbar,
        )

    def toolbar(self) -> str:
        light = self._shell.light
        target = light.connection.target
        silent_us = light.connection.pacer.now_us() - light.heard_us
        if silent_us >= SILENCE_US:
            what = f"SILENT for {silent_us // 1_000_000} s"
        else:
            what = str(light.status) if light.status else "no status yet"
        return f" {target.system}/{target.component} at {light.connection.link}: {what} "

    def run(self) -> int:
        code = OK
        with patch_stdout(raw=True):
            while not self._shell.is_done:
                try:
                    text = self._session.prompt("pharos> ", pre_run=self._listen)
                except KeyboardInterrupt:
                    continue  # drops the line
                except EOFError:
                    break
                except PharosError as error:
                    self._shell.printer.error(error)
                    return 3
                try:
                    code = self._shell.execute(text)
                except KeyboardInterrupt:
                    continue
        return code

    def _listen(self) -> None:
        get_app().create_background_task(self._live())

    async def _live(self) -> None:
        """Hears the light while the user types, so that the toolbar is live and the link stays
        open."""
        app: Any = get_app()
        shown = ""
        while True:
            try:
                self._shell.light.poll()
            except PharosError as error:
                app.exit(exception=error)
                return
            self._shell.print_texts()
            if self.toolbar() != shown:
                shown = self.toolbar()
                app.invalidate()
            await asyncio.sleep(POLL_S)
