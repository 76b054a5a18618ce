# SPDX-License-Identifier: Apache-2.0
"""MAVLink FTP and component metadata, where a light offers them. Files are only read."""

from __future__ import annotations

import json
import lzma
from typing import Any

from ..ftp import (
    ACK,
    BURST,
    CRC32,
    DATA_MAX,
    EOF,
    INVALID_SESSION,
    LIST,
    NAK,
    NOT_FOUND,
    OPEN,
    READ,
    RESET,
    TERMINATE,
    UNKNOWN_COMMAND,
    Reply,
    crc32,
    payload,
    reply_of,
)
from .bench import Bench
from .parameters import listed
from .spec import Failed, Level, NotOffered, expect, group, requirement

PAGE = "services/ftp.html"
METADATA_PAGE = "services/component_metadata.html"
CAPABILITY_FTP = 32
FILE_MAX = 1 << 20
ANSWER_US = 1_000_000
TRIES = 3
NO_FILE = "/no/such/file"

group("FT", "MAVLink FTP")
group("MD", "Component metadata")


class Files:
    """An FTP client, one request at a time. `sequence` goes on over all of them."""

    sequence = 100

    def __init__(self, bench: Bench) -> None:
        self.bench = bench

    def send(
        self, opcode: int, data: bytes = b"", session: int = 0, offset: int = 0, size: int = -1
    ) -> None:
        content = payload(Files.sequence, session, opcode, offset, data, size)
        target = self.bench.target
        self.bench.note(f"→ FTP opcode {opcode}, sequence {Files.sequence}, {data[:60]!r}")
        self.bench.connection.send(
            self.bench.d.MAVLink_file_transfer_protocol_message(
                0, target.system, target.component, content
            )
        )

    def next_reply(self) -> Reply | None:
        message = self.bench.wait_for("FILE_TRANSFER_PROTOCOL", ANSWER_US)
        if message is None:
            return None
        reply = reply_of(message)
        self.bench.note(
            f"← FTP {'ACK' if reply.opcode == ACK else f'NAK {reply.error}'} of {reply.request}, "
            f"sequence {reply.sequence}, {len(reply.data)} bytes"
        )
        return reply

    def ask(self, opcode: int, data: bytes = b"", **fields: int) -> Reply:
        """The answer; what is lost is sent again with its number, as the protocol has it."""
        self.bench.listen(0)
        Files.sequence = (Files.sequence + 2) % 65536
        for _ in range(TRIES):
            self.send(opcode, data, **fields)
            reply = self.next_reply()
            if reply is not None:
                return reply
        raise Failed(f"no answer to FTP opcode {opcode}")

    def read(self, path: str) -> bytes:
        reply = self.ask(OPEN, path.encode())
        expect(reply.error == 0, f"OpenFileRO {path}: error {reply.error}")
        session, size = reply.session, reply.number
        expect(size <= FILE_MAX, f"{path} has {size} bytes")
        content = b""
        while len(content) < size:
            part = self.ask(READ, session=session, offset=len(content), size=DATA_MAX)
            expect(part.error == 0, f"ReadFile at {len(content)} of {size}: error {part.error}")
            expect(bool(part.data), f"ReadFile at {len(content)} of {size}: no bytes")
            content += part.data
        self.ask(TERMINATE, session=session)
        return content

    def entries(self) -> list[str]:
        """Files of the root folder."""
        found: list[str] = []
        offset = 0
        while True:
            reply = self.ask(LIST, b"/", offset=offset)
            if reply.error == EOF or reply.error and found:
                return found
            expect(reply.error == 0, f"ListDirectory /: error {reply.error}")
            names = [entry for entry in reply.data.split(b"\0") if entry]
            if not names:
                return found
            offset += len(names)
            found += [
                "/" + name[1:].partition(b"\t")[0].decode("utf-8", "backslashreplace")
                for name in names
                if name[:1] == b"F"
            ]


def ftp(bench: Bench) -> Files:
    if not bench.capabilities() & CAPABILITY_FTP:
        raise NotOffered("the light does not say that it has FTP (capability 32)")
    return Files(bench)


def a_file(bench: Bench) -> tuple[Files, str]:
    files = ftp(bench)
    found = files.entries()
    if not found:
        raise NotOffered("no file in its root folder")
    return files, found[0]


@requirement("FT-1", Level.MUST, "has the FTP that it says it has", "FTP, Protocol Discovery", PAGE)
def offered(bench: Bench) -> None:
    """With capability FTP (32), ListDirectory of / is answered by an ACK, or by a NAK with a
    reason."""
    reply = ftp(bench).ask(LIST, b"/")
    expect(reply.opcode in (ACK, NAK), f"opcode {reply.opcode}")


@requirement("FT-2", Level.MUST, "says which request it answers", "FTP, Payload Format", PAGE)
def numbered(bench: Bench) -> None:
    """The answer has the request's sequence number plus one, and its opcode in req_opcode."""
    files = ftp(bench)
    reply = files.ask(RESET)
    expect(
        reply.sequence == (Files.sequence + 1) % 65536,
        f"sequence {reply.sequence} after {Files.sequence}",
    )
    expect(reply.request == RESET, f"req_opcode {reply.request}, expected {RESET}")


@requirement("FT-3", Level.MUST, "says that there is no such file", "FTP, Error Codes", PAGE)
def not_found(bench: Bench) -> None:
    """OpenFileRO of a file that is not there: NAK FileNotFound (10), the code that is defined for
    it."""
    reply = ftp(bench).ask(OPEN, NO_FILE.encode())
    expect(reply.opcode == NAK, "it was opened")
    expect(reply.error == NOT_FOUND, f"NAK {reply.error}, expected 10 (FileNotFound)")


@requirement("FT-4", Level.MUST, "says that it does not know an opcode", "FTP, Error Codes", PAGE)
def unknown_opcode(bench: Bench) -> None:
    """Opcode 99: NAK UnknownCommand (7)."""
    reply = ftp(bench).ask(99)
    expect(reply.opcode == NAK and reply.error == UNKNOWN_COMMAND, f"error {reply.error}")


@requirement(
    "FT-5", Level.MUST, "answers again what is asked again", "FTP, Timeouts/Resending", PAGE
)
def again(bench: Bench) -> None:
    """The same sequence number means that the answer was lost: the same answer comes, with the same
    number."""
    files = ftp(bench)
    first = files.ask(LIST, b"/")
    files.send(LIST, b"/")
    second = files.next_reply()
    expect(second is not None, "no answer to the repeated request")
    expect(second == first, f"first {first}, then {second}")


@requirement("FT-6", Level.MUST, "reads a file to its end", "FTP, Reading a File", PAGE)
def reads(bench: Bench) -> None:
    """ReadFile brings as many bytes as OpenFileRO said; after the last, NAK EOF (6); after
    TerminateSession, NAK InvalidSession (4)."""
    files, path = a_file(bench)
    reply = files.ask(OPEN, path.encode())
    expect(reply.error == 0, f"OpenFileRO {path}: error {reply.error}")
    session, size = reply.session, reply.number
    beyond = files.ask(READ, session=session, offset=size, size=DATA_MAX)
    expect(beyond.error == EOF, f"ReadFile at the end: error {beyond.error}, expected 6 (EOF)")
    expect(files.ask(TERMINATE, session=session).error == 0, "TerminateSession was refused")
    closed = files.ask(READ, session=session, offset=0, size=DATA_MAX)
    expect(closed.error == INVALID_SESSION, f"ReadFile of a closed session: error {closed.error}")
    content = files.read(path)
    expect(len(content) == size, f"OpenFileRO said {size} bytes, {len(content)} came")


@requirement("FT-7", Level.SHOULD, "reads a file in bursts", "FTP, BurstReadFile", PAGE)
def bursts(bench: Bench) -> None:
    """BurstReadFile brings the same bytes as ReadFile, and marks its last part."""
    files, path = a_file(bench)
    content = files.read(path)
    reply = files.ask(OPEN, path.encode())
    session = reply.session
    got = bytearray()
    try:
        while len(got) < len(content):
            part: Reply | None = files.ask(BURST, session=session, offset=len(got), size=DATA_MAX)
            while part is not None:
                expect(part.error in (0, EOF), f"error {part.error} at {len(got)}")
                if part.error == EOF:
                    break
                expect(part.offset == len(got), f"a part at {part.offset}, expected {len(got)}")
                got += part.data
                part = None if part.is_last else files.next_reply()
            if part is not None:
                break
    finally:
        files.ask(TERMINATE, session=session)
    expect(bytes(got) == content, "other bytes than ReadFile brought")


@requirement("FT-8", Level.SHOULD, "sums a file up", "FTP, CalcFileCRC32", PAGE)
def sums(bench: Bench) -> None:
    """CalcFileCRC32 is the CRC-32 of what ReadFile brings."""
    files, path = a_file(bench)
    reply = files.ask(CRC32, path.encode())
    expect(reply.error == 0, f"error {reply.error}")
    expected = crc32(files.read(path))
    got = reply.number
    expect(got == expected, f"CRC {got:#010x}, of the file {expected:#010x}")


# --- metadata -------------------------------------------------------------------------------------
def metadata(bench: Bench) -> Any:
    try:
        message = bench.request(397, "COMPONENT_METADATA")
    except Failed as error:
        raise NotOffered(f"the light has no COMPONENT_METADATA: {error}") from None
    if not uri_of(message):
        raise NotOffered("COMPONENT_METADATA names no file")
    return message


def uri_of(message: Any) -> str:
    return str(message.uri).rstrip("\0")


def fetched(bench: Bench, uri: str) -> bytes:
    """The file that an mftp: URI names, as it lies on the device."""
    expect(uri.startswith("mftp://"), f"'{uri}' is no mftp:// URI")
    path = uri.removeprefix("mftp://")
    if path.startswith("[;comp="):
        path = path.partition("]")[2]
    return Files(bench).read("/" + path.lstrip("/"))


def unpacked(content: bytes, uri: str) -> Any:
    try:
        data = lzma.decompress(content) if uri.endswith(".xz") else content
        return json.loads(data)
    except (lzma.LZMAError, ValueError) as error:
        raise Failed(f"{uri} is no JSON: {error}") from error


@requirement("MD-1", Level.MUST, "keeps its general metadata on the device",
             "Component Metadata, File Locations", METADATA_PAGE)  # fmt: skip
def general(bench: Bench) -> None:
    """COMPONENT_METADATA.uri is an mftp:// URI, and its file can be read over FTP."""
    fetched(bench, uri_of(metadata(bench)))


@requirement("MD-2", Level.MUST, "gives its general file's checksum",
             "Component Metadata, Metadata Caching", METADATA_PAGE)  # fmt: skip
def checksum(bench: Bench) -> None:
    """COMPONENT_METADATA.file_crc is the CRC-32 of the file, or a station keeps an old one."""
    message = metadata(bench)
    expected = crc32(fetched(bench, uri_of(message)))
    expect(
        int(message.file_crc) == expected,
        f"file_crc {message.file_crc:#010x}, of the file {expected:#010x}",
    )


@requirement("MD-3", Level.MUST, "describes itself in JSON",
             "Component Metadata, File Format", METADATA_PAGE)  # fmt: skip
def is_json(bench: Bench) -> None:
    """The general file is JSON (.xz: compressed) with "version" and "metadataTypes", each of
    these with "type" and "uri"."""
    uri = uri_of(metadata(bench))
    content = unpacked(fetched(bench, uri), uri)
    expect(
        isinstance(content, dict) and {"version", "metadataTypes"} <= content.keys(),
        "it lacks version or metadataTypes",
    )
    for entry in content["metadataTypes"]:
        expect({"type", "uri"} <= entry.keys(), f"a metadata type lacks type or uri: {entry}")


@requirement("MD-4", Level.MUST, "has the files that it names on the device",
             "Component Metadata, File Locations", METADATA_PAGE)  # fmt: skip
def files_exist(bench: Bench) -> None:
    """Each mftp:// URI of the general file can be read, is JSON, and has its checksum where one is
    given."""
    uri = uri_of(metadata(bench))
    for entry in unpacked(fetched(bench, uri), uri)["metadataTypes"]:
        if not str(entry["uri"]).startswith("mftp://"):
            continue
        content = fetched(bench, entry["uri"])
        unpacked(content, entry["uri"])
        if "fileCrc" in entry:
            expect(entry["fileCrc"] == crc32(content), f"{entry['uri']}: fileCrc does not fit")


@requirement("MD-5", Level.SHOULD, "describes each of its parameters",
             "Component Metadata, Parameter metadata", METADATA_PAGE)  # fmt: skip
def parameters_described(bench: Bench) -> None:
    """The file of parameters (type 1) has those of the list, and no others."""
    uri = uri_of(metadata(bench))
    general = unpacked(fetched(bench, uri), uri)
    uris = [entry["uri"] for entry in general["metadataTypes"] if entry["type"] == 1]
    if not uris or not str(uris[0]).startswith("mftp://"):
        raise NotOffered("no file of parameters on the device")
    described = {p["name"] for p in unpacked(fetched(bench, uris[0]), uris[0])["parameters"]}
    listed(bench)
    known = set(bench.facts.parameters or {})
    expect(not known - described, f"not described: {sorted(known - described)[:5]}")
