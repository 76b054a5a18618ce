# SPDX-License-Identifier: Apache-2.0
"""What a light written the usual way would be, and nothing more: pymavlink on a UDP socket. Prints
its port, then acknowledges every COMMAND_LONG until it is killed. Argument: the dialect's file."""

from __future__ import annotations

import socket
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "host" / "src"))

from pharos import load_dialect


def main() -> None:
    dialect = load_dialect(sys.argv[1])
    codec = dialect.MAVLink(None, 1, 243)
    codec.robust_parsing = True
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        sock.bind(("127.0.0.1", 0))
        print(sock.getsockname()[1], flush=True)
        while True:
            data, peer = sock.recvfrom(2048)
            for message in codec.parse_buffer(data) or []:
                if message.get_msgId() != 76:  # COMMAND_LONG
                    continue
                ack = dialect.MAVLink_command_ack_message(
                    message.command, 0, 0, 0, message.get_srcSystem(), message.get_srcComponent()
                )
                sock.sendto(ack.pack(codec), peer)
                codec.seq = (codec.seq + 1) % 256


if __name__ == "__main__":
    main()
