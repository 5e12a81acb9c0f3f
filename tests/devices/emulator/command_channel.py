"""The command channel of the camera: registers, fixed blocks, image sensor; sections 2, 3 and 6 of the notes."""

import struct

# as documented in public projects [cm]: emitter to depth camera, depth to colour camera, reference plane, its pixel
ZERO_PLANE = (7.5, 2.3, 120.0, 0.1042)
CONST_SHIFT = 200
PADDING = (0, 0, 0)  # start lines, end lines, cropping lines
# of no real unit: a shift of 10 and -4 px and a growth of some px over the image; the rest is 0
REGISTRATION = {"dx_start": 10 * 256, "dy_start": -4 * 256, "dxdx_start": 300, "dydy_start": 250, "ax": 1, "by": -1}
# 29, as the notes count
REGISTRATION_ORDER = [
    "dx_center", "ax", "bx", "cx", "dx", "dx_start", "ay", "by", "cy", "dy", "dy_start", "dx_beta_start",
    "dy_beta_start", "rollout_blank", "rollout_size", "dx_beta_inc", "dy_beta_inc", "dxdx_start", "dxdy_start",
    "dydx_start", "dydy_start", "dxdxdx_start", "dydxdx_start", "dxdxdy_start", "dydxdy_start", "back_comp1",
    "dydydx_start", "back_comp2", "dydydy_start",
]  # fmt: skip
FIXED_BYTES = 322  # of a 1414
OK, UNKNOWN = 0, 5  # the notes name only 0; what an unknown command gets is a guess


class Commands:
    """Registers and what a command answers. `changed(register, value)` is called after each register that is set."""

    def __init__(self, changed) -> None:
        self.registers: dict[int, int] = {}
        self.sensor: dict[int, int] = {0x106: 0x4082, 0x009: 600}  # automatic exposure and white; shutter
        self._changed = changed

    def answer(self, request: bytes) -> bytes | None:
        """The whole reply to a whole request; None where the request is not one (a real camera stays silent)."""
        if len(request) < 8 or request[:2] != b"GM":
            return None
        words, command, tag = struct.unpack_from("<HHH", request, 2)
        payload = request[8:]
        if len(payload) != 2 * words:
            return None
        answer = self._payload(command, payload)
        return struct.pack("<2sHHH", b"RB", len(answer) // 2, command, tag) + answer

    def _payload(self, command: int, payload: bytes) -> bytes:
        words = struct.unpack(f"<{len(payload) // 2}H", payload)
        if command == 0x00:
            return struct.pack("<8H", OK, 1, 0, 11, 0, 0, 0, 0)  # the block's content is not in the notes
        if command == 0x01:
            return struct.pack("<H", OK)
        if command == 0x02 and words:
            return struct.pack("<HH", OK, self.registers.get(words[0], 0))
        if command == 0x03 and len(words) == 2:
            self.registers[words[0]] = words[1]
            self._changed(*words)
            return struct.pack("<H", OK)
        if command == 0x04:
            return (bytes(94) + struct.pack("<4f", *ZERO_PLANE)).ljust(FIXED_BYTES, b"\0")
        if command == 0x16 and words:
            return _algorithm(words[0])
        if command == 0x95 and len(words) == 3:
            return self._sensor(*words)
        return struct.pack("<H", UNKNOWN)

    def _sensor(self, count: int, register: int, value: int) -> bytes:
        place = register & 0x7FFF
        if register & 0x8000:
            self.sensor[place] = value
        return struct.pack("<3H", count, place, self.sensor.get(place, 0))


def _algorithm(which: int) -> bytes:
    if which == 0x00:
        return struct.pack("<HH", OK, CONST_SHIFT)
    if which == 0x40:
        return struct.pack("<H29i", OK, *(REGISTRATION.get(name, 0) for name in REGISTRATION_ORDER))
    if which == 0x41:
        return struct.pack("<4H", OK, *PADDING)
    return struct.pack("<H", UNKNOWN)
