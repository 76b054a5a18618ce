# SPDX-License-Identifier: Apache-2.0
"""A DroneCAN node on any python-can bus.

`CanPort` is one program's place on a bus, `DronecanNode` a node there. Nothing here waits or looks
at a clock: whoever owns the time polls the port and calls step() (RealPacer, Simulator).
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from typing import Any

import can
import dronecan
from dronecan import transport, uavcan

from .can_transfer import Assembler, Header, Transfer, pack, split
from .errors import LinkError, SilentError, UrlError
from .link import Pacer, Port

STATUS_PERIOD_US = 1_000_000
OWN_NODE = 126
NAME = "org.pharos.host"
PRIORITY = 20
REQUEST_TIMEOUT_US = 1_000_000


def open_bus(interface: str, channel: str, *, fd: bool = False, **options: Any) -> can.BusABC:
    """A python-can bus. UrlError: no such interface type; LinkError: it is not there."""
    if interface == "pharos-udp":
        from .can_udp import PharosUdpBus

        return PharosUdpBus(channel, fd=fd)
    where = f"{interface}/{channel}" if channel else interface
    if interface not in can.VALID_INTERFACES:
        known = ", ".join(sorted(can.VALID_INTERFACES))
        raise UrlError(f"'{interface}' is no interface of python-can; it has {known}")
    if fd:
        options["fd"] = True
    try:
        return can.Bus(interface=interface, channel=channel or None, **options)
    except can.CanInterfaceNotImplementedError as error:
        raise UrlError(f"{where}: {_first_line(error)}") from error
    except OSError as error:
        raise LinkError(f"{where}: {error.strerror or error}") from error
    except Exception as error:  # a plug-in's own kinds, of which there is no list
        raise LinkError(f"{where}: {_first_line(error)}") from error


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]


class CanPort(Port):
    """One place on a CAN bus, shared by any number of nodes. `sent` and `received` count frames."""

    unit = "frames"
    unit_weight = 4

    def __init__(self, bus: can.BusABC) -> None:
        super().__init__()
        self.bus = bus
        self.nodes: list[DronecanNode] = []
        self.listeners: list[Callable[[can.Message], None]] = []
        self._fileno = _fileno(bus)

    def fileno(self) -> int:
        """-1: this kind of bus has none."""
        return self._fileno

    def send(self, identifier: int, data: bytes, fd: bool) -> None:
        message = can.Message(arbitration_id=identifier, data=data, is_fd=fd, bitrate_switch=fd)
        try:
            self.bus.send(message)
        except (can.CanError, OSError) as error:
            raise LinkError(f"{self}: {_first_line(error)}") from error
        self.sent += 1

    def poll(self, timeout_s: float) -> bool:
        """Takes one frame, waiting up to `timeout_s` of host time for it."""
        try:
            message = self.bus.recv(timeout_s)
        except (can.CanError, OSError) as error:
            raise LinkError(f"{self}: {_first_line(error)}") from error
        if message is None:
            return False
        self.received += 1
        for listener in self.listeners:
            listener(message)
        if message.is_extended_id and not message.is_remote_frame and not message.is_error_frame:
            for node in list(self.nodes):
                node.receive(message.arbitration_id, bytes(message.data), message.is_fd)
        return True

    def step(self, now_us: int) -> int | None:
        dues = [due for node in self.nodes if (due := node.step(now_us)) is not None]
        return min(dues, default=None)

    def close(self) -> None:
        self.bus.shutdown()

    def __str__(self) -> str:
        return str(self.bus.channel_info)


def _fileno(bus: can.BusABC) -> int:
    try:
        return bus.fileno()
    except NotImplementedError:
        return -1


class DronecanNode:
    """A node. node_id 0: only listens. It sends NodeStatus at 1 Hz, answers GetNodeInfo, and what
    subscribe() and serve() say. fd: its transfers go out in CAN FD frames."""

    def __init__(
        self,
        port: CanPort,
        clock: Callable[[], int],
        node_id: int = OWN_NODE,
        *,
        name: str = NAME,
        fd: bool = False,
    ) -> None:
        self.port = port
        self.clock = clock
        self.node_id = node_id
        self.name = name
        self.fd = fd
        self.assembler = Assembler()
        # Called with each complete transfer, whomever it is for.
        self.monitors: list[Callable[[Transfer], None]] = []
        # Called at each step with the time; return when they want to be called again.
        self.steppers: list[Callable[[int], int]] = []
        self._subscribers: dict[Any, list[Callable[[Transfer], None]]] = defaultdict(list)
        self._servers: dict[Any, Callable[[Transfer], Any]] = {}
        self._waiting: dict[tuple[int, int, int], Callable[[Any], None]] = {}
        self._transfer_ids: dict[tuple[Any, ...], int] = defaultdict(int)
        self._started_us = clock()
        self._status_us = self._started_us
        self.serve(uavcan.protocol.GetNodeInfo, self._node_info)
        port.nodes.append(self)

    # --- sending ------------------------------------------------------------------------------
    def broadcast(self, message: Any, priority: int = PRIORITY) -> None:
        header = Header(_type_id(message), self.node_id, priority)
        key = (header.type_id,)
        self._send(header, message, self._next_id(key), self.fd)

    def request(
        self,
        message: Any,
        destination: int,
        on_response: Callable[[Any], None],
        priority: int = PRIORITY,
    ) -> None:
        """on_response gets the response's payload, if one comes."""
        header = Header(_type_id(message), self.node_id, priority, destination, True)
        transfer_id = self._next_id((header.type_id, destination))
        self._waiting[header.type_id, destination, transfer_id] = on_response
        self._send(header, message, transfer_id, self.fd)

    def ask(
        self, message: Any, destination: int, pacer: Pacer, timeout_us: int = REQUEST_TIMEOUT_US
    ) -> Any:
        """The response; time passes through `pacer`. SilentError: none came."""
        answers: list[Any] = []
        self.request(message, destination, answers.append)
        end = self.clock() + timeout_us
        pacer.pump(0)
        while not answers and (left := end - self.clock()) > 0:
            pacer.pump(min(left, 10_000))
        if not answers:
            name = transport.get_dronecan_data_type(message).full_name
            raise SilentError(f"node {destination} did not answer {name} over {self.port}")
        return answers[0]

    def _next_id(self, key: tuple[Any, ...]) -> int:
        transfer_id = self._transfer_ids[key]
        self._transfer_ids[key] = (transfer_id + 1) % 32
        return transfer_id

    def _send(self, header: Header, message: Any, transfer_id: int, fd: bool) -> None:
        if self.node_id == 0:
            raise LinkError(f"{self.port}: a node without an id only listens")
        seed = transport.get_dronecan_data_type(message).base_crc
        for data in split(pack(message, fd), seed, transfer_id, fd):
            self.port.send(header.identifier, data, fd)

    # --- receiving ----------------------------------------------------------------------------
    def subscribe(self, kind: Any, handler: Callable[[Transfer], None]) -> None:
        self._subscribers[kind].append(handler)

    def serve(self, kind: Any, handler: Callable[[Transfer], Any]) -> None:
        """handler returns the response to each request of that type."""
        self._servers[kind] = handler

    def receive(self, identifier: int, data: bytes, fd: bool) -> None:
        transfer = self.assembler.receive(self.clock(), identifier, data, fd)
        if transfer is None:
            return
        for monitor in self.monitors:
            monitor(transfer)
        header = transfer.header
        if not header.is_service:
            for handler in self._subscribers.get(transfer.kind, []):
                handler(transfer)
        elif header.destination == self.node_id and self.node_id:
            if header.is_request:
                self._respond(transfer)
            else:
                key = (header.type_id, header.source, transfer.transfer_id)
                on_response = self._waiting.pop(key, None)
                if on_response is not None:
                    on_response(transfer.message)

    def _respond(self, request: Transfer) -> None:
        server = self._servers.get(request.kind)
        if server is None:
            return
        of = request.header
        header = Header(of.type_id, self.node_id, of.priority, of.source)
        self._send(header, server(request), request.transfer_id, request.fd)

    def close(self) -> None:
        """Leaves the port, which stays open."""
        if self in self.port.nodes:
            self.port.nodes.remove(self)

    # --- time ---------------------------------------------------------------------------------
    def step(self, now_us: int) -> int | None:
        """Does what is due; returns when to call again."""
        dues = [stepper(now_us) for stepper in self.steppers]
        if self.node_id == 0:
            return min(dues, default=None)
        if now_us >= self._status_us:
            self.broadcast(self._status())
            self._status_us += STATUS_PERIOD_US
            if self._status_us <= now_us:
                self._status_us = now_us + STATUS_PERIOD_US
        return min([*dues, self._status_us])

    def _status(self) -> Any:
        status = uavcan.protocol.NodeStatus()
        status.uptime_sec = (self.clock() - self._started_us) // 1_000_000
        status.mode = status.MODE_OPERATIONAL
        return status

    def _node_info(self, _request: Transfer) -> Any:
        info = uavcan.protocol.GetNodeInfo.Response()
        info.status = self._status()
        info.name.encode(self.name)
        return info


def _type_id(message: Any) -> int:
    return int(transport.get_dronecan_data_type(message).default_dtid)


class BusDriver:
    """Puts a node of PyPI's dronecan (`dronecan.node.Node(BusDriver(port), …)`) on a CanPort, in
    place of that library's own python-can driver. Whoever polls the port feeds the node."""

    def __init__(self, port: CanPort, clock: Callable[[], int]) -> None:
        self._port = port
        self._clock = clock
        self._frames: list[Any] = []
        port.listeners.append(self._frames.append)

    def send(
        self, message_id: int, message: bytes, extended: bool = True, canfd: bool = False
    ) -> None:
        del extended  # DroneCAN has no other frames
        self._port.send(message_id, bytes(message), canfd)

    def receive(self, timeout: float | None = None) -> Any:
        """The next frame at hand. Never waits."""
        del timeout
        if not self._frames:
            return None
        message = self._frames.pop(0)
        now_s = self._clock() / 1e6
        return _Frame(message, now_s)

    def close(self) -> None:
        self._port.close()


class _Frame:
    def __init__(self, message: can.Message, now_s: float) -> None:
        self.id = message.arbitration_id
        self.data = bytes(message.data)
        self.extended = message.is_extended_id
        self.canfd = message.is_fd
        self.ts_monotonic = now_s
        self.ts_real = now_s


def fields_of(message: Any) -> dict[str, Any]:
    """A message as plain Python: numbers, text, lists, mappings; bytes that are no text as hex."""
    fields = transport.get_fields(message).items()
    return {name: _plain(value) for name, value in fields if not name.startswith("_void_")}


def _plain(value: Any) -> Any:
    if isinstance(value, transport.PrimitiveValue):
        return value.value
    if isinstance(value, transport.ArrayValue):
        return _plain_array(value)
    if transport.is_union(value):
        name = transport.get_active_union_field(value)
        return {name: _plain(transport.get_fields(value)[name])} if name else {}
    return fields_of(value)


def _plain_array(array: Any) -> Any:
    item = transport.get_dronecan_data_type(array).value_type
    primitive = dronecan.dsdl.PrimitiveType
    if not isinstance(item, primitive):
        return [_plain(value) for value in array]
    if (item.kind, item.bitlen) != (primitive.KIND_UNSIGNED_INT, 8):
        return list(array)
    data = bytes(array.to_bytes())
    is_text = all(32 <= byte < 127 for byte in data)
    return data.decode("ascii") if is_text else data.hex()
