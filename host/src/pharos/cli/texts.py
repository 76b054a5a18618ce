# SPDX-License-Identifier: Apache-2.0
"""What `pharos COMMAND --help` says below the options."""

from __future__ import annotations

CODES = """exit codes: 0 done; 1 refused or failed; 2 not understood; 3 silent or unreachable"""

MAIN = f"""\
examples:
  pharos find
  pharos on udp:127.0.0.1:14550
  pharos strobe /dev/ttyUSB0,57600 2Hz 10
  pharos param save udp:127.0.0.1:14550 light.parm
  pharos shell udp:127.0.0.1:14550                     a prompt
  pharos shell /dev/ttyUSB0,57600 -c 'on; brightness 40'
  pharos shell 'dronecan:socketcan/can0?node=68' --json < commands.txt
  pharos check udp:127.0.0.1:14550 --html report.html  does it keep to the protocol?
  pharos update zephyr.signed.bin udp:127.0.0.1:14550
  pharos can nodes socketcan/can0                      who is on the bus
  pharos imc send tcp:127.0.0.1:6443 SetLedBrightness name=lamp value=128

{CODES}
"""

SHELL = f"""\
URL is one of
  udp:HOST:PORT                     a light that listens there (its wire is udpin:)
  udpin:HOST:PORT                   listen for a light that sends there (udpout:)
  tcp:HOST:PORT, tcpin:HOST:PORT    the same over TCP
  pty:PATH, serial:DEVICE,BAUD      a terminal or a serial line; /dev/… alone will do
  dronecan:INTERFACE/CHANNEL?node=N[&own=M][&serial=0][&fd=1][&bitrate=B]
                                    node N through DroneCAN's tunnel; INTERFACE is python-can's:
                                    socketcan, slcan, pharos-udp (no CHANNEL: the default bus) …

example:
  pharos shell udp:127.0.0.1:14550 -c 'on; strobe 2Hz 10; status'

Without -c, commands are read from the terminal, or one line at a time from a pipe; the first that
fails ends it. `pharos shell URL -c help` lists the commands.

{CODES}
"""

PARAM = f"""\
ACTION is one of
  list [PATTERN]   all, or those like 'LGT_*'
  get NAME         one
  set NAME VALUE   and what is in force then
  save FILE        for MAVProxy and Mission Planner; NAME.params for QGroundControl
  load FILE        of any of the three: sets what differs
  diff FILE        what differs; exit code 1 if anything does

examples:
  pharos param list udp:127.0.0.1:14550 'LGT_*'
  pharos param set udp:127.0.0.1:14550 LGT_FALLBACK 1

{CODES}
"""

COMPLETION = """\
examples:
  eval "$(pharos completion bash)"                             in ~/.bashrc
  eval "$(pharos completion zsh)"                              in ~/.zshrc, after compinit
  pharos completion fish > ~/.config/fish/completions/pharos.fish
"""

FIND = f"""\
PLACE is a URL as for `pharos shell`, and also
  udp:ADDRESS:PORT            a broadcast address: every light there
  can:INTERFACE[/CHANNEL]     every node of that bus, through DroneCAN's tunnel
  imc:                        what IMC's nodes announce, every 10 s
Without one, the usual: UDP ports 14540 and 14550 here and on the networks, TCP port 5770, USB
serial lines, CAN interfaces, and IMC.

examples:
  pharos find
  pharos find udp:192.168.1.255:14550 --json

{CODES}
"""

CHECK = """\
examples:
  pharos check udp:127.0.0.1:14550
  pharos check serial:/dev/ttyUSB0,57600 --junit check.xml --html check.html
  pharos check --explain CF-12
  pharos check udp:127.0.0.1:14550 --only 'CF-*' --skip CF-6 -v
  pharos check 'dronecan:socketcan/can0?node=68' --profile dronecan
  pharos check tcp:127.0.0.1:6443 --profile imc

exit codes: 0 no must fails; 1 a must fails; 2 not understood; 3 silent or unreachable
"""

UPDATE = f"""\
A light with MCUboot takes FILE (zephyr.signed.bin), verifies it, restarts, and has to run for 10 s.
Over dronecan:…?node=N,N,… DroneCAN's own way is used, for all these nodes at once; over any other
URL, or with --via mavlink, MAVLink FTP, signed if there is a key. What was lost goes on where it
was; --patience says how long it is waited for.

examples:
  pharos update zephyr.signed.bin serial:/dev/ttyUSB0,57600
  pharos update zephyr.signed.bin 'dronecan:socketcan/can0?node=68,69,70'

{CODES}
"""
