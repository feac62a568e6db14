#!/usr/bin/env python3
"""Boots an image of the flight computer without one, and checks what it writes into the chip's registers.

Unicorn executes the image on a bare Cortex-M7 core: memory where the chip has it, and registers that read back what was
written, but for the few that a program waits on. Interrupts are entered by hand: the timer of the alarms, whenever the
program sleeps, and the trigger's, when its compare falls due. On the sensor's bus sits a sensor of registers alone, in the slot a
card (card.py). What is proved: the program runs from reset to its
idle loop with interrupts on, and leaves every register as the reference manual (RM0433) wants it for this board. What is
not: that the chip behaves as the manual says.

Usage: rehearsal.py IMAGE FLASH_ORIGIN REV_ID [CONFIGURATION]; exit 0 = all as expected, 1 = not.
"""

import struct
import sys
import zlib

from card import Card
from unicorn import UC_ARCH_ARM, UC_HOOK_INSN_INVALID, UC_HOOK_INTR, UC_MODE_MCLASS, UC_MODE_THUMB, Uc, UcError
from unicorn import arm_const as arm

RAM = [(0x00000000, 0x10000), (0x08000000, 0x200000), (0x20000000, 0x20000), (0x24000000, 0x80000),
       (0x30000000, 0x48000), (0x38000000, 0x10000), (0x38800000, 0x1000)]
TIM5, TIM5_IRQ, TIM3, TIM3_IRQ = 0x40000C00, 50, 0x40000400, 29
I2C1, SDMMC1, OTG = 0x40005400, 0x52007000, 0x40080000
RCC, PWR, RNG = 0x58024400, 0x58024800, 0x48021800
DBGMCU_IDC = 0x5C001000


def double(bits):
    return struct.unpack("<d", struct.pack("<Q", bits))[0]


def bits_of(value):
    return struct.unpack("<Q", struct.pack("<d", value))[0]


def single(bits):
    return struct.unpack("<f", struct.pack("<I", bits))[0]


class Doubles:
    """The double-precision instructions of the Cortex-M7, which Unicorn's lacks (ARMv7-M A7.7, coprocessor 11).

    What a boot needs of them: it computes filters, not fixes. Fused multiplications round twice here.
    """

    def __init__(self, uc):
        self.uc, self.count = uc, 0
        uc.hook_add(UC_HOOK_INSN_INVALID, self.step)

    def step(self, uc, _data):
        pc = uc.reg_read(arm.UC_ARM_REG_PC)
        first, second = struct.unpack("<HH", uc.mem_read(pc, 4))
        if first & 0xFF00 != 0xEE00 or second & 0x0E10 != 0x0A00 or not self.compute(first, second):
            return False
        self.count += 1
        uc.reg_write(arm.UC_ARM_REG_PC, pc + 4 | 1)
        return True

    def compute(self, first, second):
        is_double = second >> 8 & 1
        d = (first >> 6 & 1) << 4 | second >> 12
        n = (second >> 7 & 1) << 4 | first & 15
        m = (second >> 5 & 1) << 4 | second & 15
        read = lambda k: double(self.uc.reg_read(arm.UC_ARM_REG_D0 + k))
        write = lambda k, value: self.uc.reg_write(arm.UC_ARM_REG_D0 + k, bits_of(value))
        s_d, s_m = (second >> 12) << 1 | first >> 6 & 1, (second & 15) << 1 | second >> 5 & 1
        word = self.uc.reg_read(arm.UC_ARM_REG_S0 + s_m)
        op, is_second = first >> 5 & 4 | first >> 4 & 3, second >> 6 & 1
        if op == 7:
            kind, variant = first & 15, second >> 6 & 3
            if kind == 7 and not is_double:
                write(d, single(word))
            elif not is_double:
                return False
            elif kind == 7:
                self.uc.reg_write(arm.UC_ARM_REG_S0 + s_d, struct.unpack("<I", struct.pack("<f", read(m)))[0])
            elif kind in (0, 1) and is_second:
                value = read(m)
                write(d, {(0, 1): value, (0, 3): abs(value), (1, 1): -value, (1, 3): max(value, 0.0) ** 0.5}[kind, variant])
            elif not is_second:
                low = second & 15 | (first & 15) << 4
                sign, exponent, fraction = low >> 7, (low >> 4 & 7) ^ 4, low & 15
                write(d, (-1) ** sign * (16 + fraction) / 16 * 2.0 ** (exponent - 3))
            elif kind in (4, 5):
                a, b = read(d), read(m) if kind == 4 else 0.0
                flags = 3 if a != a or b != b else 6 if a == b else 8 if a < b else 2
                status = self.uc.reg_read(arm.UC_ARM_REG_FPSCR) & 0x0FFFFFFF
                self.uc.reg_write(arm.UC_ARM_REG_FPSCR, status | flags << 28)
            elif kind == 8:
                write(d, float(word - (word >> 31 << 32) if second >> 7 & 1 else word))
            elif kind in (12, 13):
                low, high = (-1 << 31, (1 << 31) - 1) if kind == 13 else (0, (1 << 32) - 1)
                value = read(m)
                value = 0 if value != value else int(max(low, min(high, value)))
                self.uc.reg_write(arm.UC_ARM_REG_S0 + s_d, value & 0xFFFFFFFF)
            else:
                return False
            return True
        if not is_double:
            return False
        a, b, c = read(n), read(m), read(d)
        if op == 4:
            write(d, a / b if b else float("inf"))
            return True
        results = {0: (c + a * b, c - a * b), 1: (a * b - c, -a * b - c), 2: (a * b, -a * b), 3: (a + b, a - b),
                   5: (a * b - c, -a * b - c), 6: (c + a * b, c - a * b)}
        write(d, results[op][is_second])
        return True


class Sensor:
    """Registers of the MT9V034 behind I2C1."""

    def __init__(self):
        self.registers = {0x00: 0x1324}
        self.number, self.bytes, self.out, self.left, self.is_reading, self.is_stopped = 0, [], [], 0, False, False

    def start(self, cr2):
        self.is_reading, self.left = bool(cr2 >> 10 & 1), cr2 >> 16 & 0xFF
        self.address = cr2 >> 1 & 0x7F  # ours, or nobody answers: see the expectation
        self.bytes = []
        value = self.registers.get(self.number, 0)
        self.out = [value >> 8, value & 0xFF]

    def write(self, byte):
        self.bytes.append(byte)
        self.left -= 1
        self.number = self.bytes[0]
        if len(self.bytes) == 3:
            self.registers[self.number] = self.bytes[1] << 8 | self.bytes[2]

    def read(self):
        self.left -= 1
        return self.out.pop(0) if self.out else 0

    def status(self, is_auto_end):
        if self.left > 0:
            return 1 << 2 if self.is_reading else 1 << 0 | 1 << 1
        return (1 << 5 if is_auto_end or self.is_stopped else 1 << 6) | 1 << 0


class Board:
    """The core and its registers."""

    def __init__(self, revision):
        self.uc = Uc(UC_ARCH_ARM, UC_MODE_THUMB | UC_MODE_MCLASS, arm.UC_CPU_ARM_CORTEX_M7)
        for address, size in RAM:
            self.uc.mem_map(address, size)
        self.uc.mmio_map(0x40000000, 0x20000000, self.read, None, self.write, None)
        self.uc.mmio_map(0xE0000000, 0x100000, self.read_core, None, self.write_core, None)
        self.values, self.core, self.trace = {}, {}, []
        self.revision, self.sensor, self.card = revision, Sensor(), Card(self.uc)
        self.mpu, self.is_asleep, self.is_done, self.ticks = {}, False, False, 0
        self.uc.hook_add(UC_HOOK_INTR, self.interrupt)
        self.doubles = Doubles(self.uc)

    def load(self, path):
        data = open(path, "rb").read()
        table, size, count = struct.unpack_from("<I", data, 28)[0], *struct.unpack_from("<HH", data, 42)
        for n in range(count):
            kind, offset, _, address, length = struct.unpack_from("<5I", data, table + n * size)
            if kind == 1 and length:
                self.uc.mem_write(address, data[offset:offset + length])

    def read(self, _uc, offset, _size, _data):
        address = 0x40000000 + offset
        value = self.values.get(address & ~3, 0) >> (address & 3) * 8
        if address == DBGMCU_IDC:
            return self.revision << 16 | 0x450
        if address == RCC:  # every oscillator and PLL that is on is ready
            for on, ready in [(0, 2), (7, 8), (12, 13), (16, 17), (24, 25), (26, 27), (28, 29)]:
                value = value & ~(1 << ready) | (value >> on & 1) << ready
            return value
        if address == RCC + 0x10:  # the switch follows
            return value & ~0x38 | (value & 7) << 3
        if address == RCC + 0x74:  # the slow oscillator follows
            return value & ~2 | (value & 1) << 1
        if address == PWR + 0x0C:  # the port's supply is there
            return value | (value >> 24 & 1) << 26
        if address in (PWR + 0x04, PWR + 0x18):  # voltages are reached
            return value | 1 << 13
        if address in (0x40000024, 0x40000424):  # TIM2 and TIM3 count together
            return self.ticks & (0xFFFFFFFF if address == 0x40000024 else 0xFFFF)
        if address == TIM5 + 0x24:
            return self.ticks & 0xFFFF
        if address == OTG + 0x10:  # the core is idle, resets are over
            return 1 << 31
        if address == OTG + 0x14:  # no host: no event
            return 0
        if address == OTG + 0x3C:  # the port's core, by the manual
            return 0x2300
        if SDMMC1 <= address < SDMMC1 + 0x400:
            return self.card.read(address - SDMMC1, value)
        if address == RNG + 4:  # a number is there
            return 1
        if address == RNG + 8:
            return 0x12345678
        if address == I2C1 + 0x18:
            return self.sensor.status(self.values.get(I2C1 + 4, 0) >> 25 & 1)
        if address == I2C1 + 0x24:
            return self.sensor.read()
        return value

    def write(self, _uc, offset, size, value, _data):
        address = 0x40000000 + offset
        word, shift = address & ~3, (address & 3) * 8
        mask = ((1 << size * 8) - 1) << shift
        value = self.values.get(word, 0) & ~mask | value << shift & mask
        if 0x58020000 <= word < 0x58022C00 and word & 0x3FF == 0x18:  # BSRR changes ODR
            odr = self.values.get(word - 4, 0)
            self.values[word - 4] = odr & ~(value >> 16) | value & 0xFFFF
        if word in (TIM5 + 0x10, 0x40000010, 0x40000410):  # flags are taken back by zeros
            value &= self.values.get(word, 0)
        if word == RCC + 0x28 and self.values.get(RCC, 0) >> 24 & 1:  # PLL1's source and M are held while it is on
            value = value & ~0x3F3 | self.values.get(word, 0) & 0x3F3
        if word == I2C1 + 4:
            if value >> 13 & 1:  # START, taken back by the bus
                self.sensor.start(value)
            self.sensor.is_stopped = bool(value >> 14 & 1)
            value &= ~(1 << 13 | 1 << 14)
        if word == I2C1 + 0x28:
            self.sensor.write(value & 0xFF)
        self.values[word] = value
        self.trace.append((word, value))
        if SDMMC1 <= word < SDMMC1 + 0x400:
            self.card.write(word - SDMMC1, value, self.values)

    def read_core(self, _uc, offset, _size, _data):
        return self.core.get(offset & ~3, 0)

    def write_core(self, _uc, offset, size, value, _data):
        if size < 4:
            shift = (offset & 3) * 8
            mask = ((1 << size * 8) - 1) << shift
            value = self.core.get(offset & ~3, 0) & ~mask | value << shift & mask
        if offset == 0xED9C and value & 1 << 4:
            self.mpu[value & 15] = [value & ~0x1F, 0]
            self.core[0xED98] = value & 15
        elif offset == 0xEDA0:
            self.mpu.setdefault(self.core.get(0xED98, 0), [0, 0])[1] = value
        elif offset == 0xED0C and value >> 16 == 0x05FA and value & 4:
            self.is_done = True
            self.uc.emu_stop()
        elif 0xE100 <= offset < 0xE180:  # ISER sets, bits stay
            value |= self.core.get(offset, 0)
        elif 0xE180 <= offset < 0xE200:
            self.core[offset - 0x80] = self.core.get(offset - 0x80, 0) & ~value
        self.core[offset & ~3] = value

    def interrupt(self, _uc, number, _data):
        self.is_done = True
        self.uc.emu_stop()

    def run(self, reset, sleeps):
        """Runs from `reset`; at each sleep half a millisecond passes and the alarms' timer has its say."""
        at = reset
        for _ in range(sleeps):
            try:
                self.uc.emu_start(at | 1, 0xFFFFFFFE, timeout=240_000_000)
            except UcError as error:
                pc = self.uc.reg_read(arm.UC_ARM_REG_PC)
                return f"{error} at {pc:#010x}"
            pc = self.uc.reg_read(arm.UC_ARM_REG_PC)
            if self.is_done:
                return f"ended at {pc:#010x}"
            if bytes(self.uc.mem_read(pc - 2, 2)) != b"\x30\xbf" and bytes(self.uc.mem_read(pc, 2)) != b"\x30\xbf":
                return f"does not sleep at {pc:#010x}"
            if bytes(self.uc.mem_read(pc, 2)) == b"\x30\xbf":
                pc += 2
            self.uc.reg_write(arm.UC_ARM_REG_PC, pc | 1)
            before, self.ticks = self.ticks, self.ticks + 500
            at = self.serve(pc, before)
            if isinstance(at, str):
                return at
        return None

    def pending(self, before):
        """Interrupts that half a millisecond has brought: the alarms', always, and the trigger's where its compare fell due."""
        yield TIM5 + 0x10, self.values.get(TIM5 + 0x0C, 0) & 0x1F, TIM5_IRQ
        compare, mode = self.values.get(TIM3 + 0x34, 0), self.values.get(TIM3 + 0x18, 0) >> 4 & 7
        due = (compare - before & 0xFFFF) <= self.ticks - before
        if due and mode in (1, 2) and self.values.get(TIM3 + 0x0C, 0) >> 1 & 1:
            yield TIM3 + 0x10, 1 << 1, TIM3_IRQ

    def serve(self, resume, before):
        """Runs the handlers to their ends; where to go on."""
        for status, flags, irq in self.pending(before):
            if not self.core.get(0xE100 + irq // 32 * 4, 0) >> irq % 32 & 1:
                continue
            self.values[status] = flags
            kept, stack = self.uc.context_save(), self.uc.reg_read(arm.UC_ARM_REG_SP)
            vtor = self.core.get(0xED08, 0)
            handler = struct.unpack("<I", self.uc.mem_read(vtor + 64 + irq * 4, 4))[0]
            self.uc.reg_write(arm.UC_ARM_REG_SP, stack - 256 & ~7)
            # Back to an address of our own instead of an exception's return.
            self.uc.reg_write(arm.UC_ARM_REG_LR, 0x081FFFF1)
            try:
                self.uc.emu_start(handler | 1, 0x081FFFF0, timeout=10_000_000)
            except UcError as error:
                return f"{error} in the handler of interrupt {irq}"
            self.uc.context_restore(kept)
        return resume


GPIO = {port: 0x58020000 + 0x400 * n for n, port in enumerate("ABCDE")}
# Pin: mode (1 output, 2 alternate) and alternate function, by the data sheet's tables 9 to 13 (DS12110).
PINS = {"PA5": (2, 1), "PB4": (2, 2), "PB10": (2, 7), "PA11": (2, 10), "PA12": (2, 10),
        "PC0": (1, None), "PC1": (1, None), "PC2": (1, None)}
PINS |= {pin: (2, 13) for pin in "PC6 PC7 PE0 PE1 PE4 PB6 PE5 PE6 PA4 PB7 PA6".split()}
# With a configuration: what is received, the servo, the sensor's clock, bus, reset and power, the card.
CAMERA_PINS = {"PB11": (2, 7), "PD12": (2, 2), "PA8": (2, 1), "PB8": (2, 4), "PB9": (2, 4), "PA10": (1, None), "PD7": (1, None)}
CAMERA_PINS |= {pin: (2, 12) for pin in ("PC8", "PC9", "PC10", "PC11", "PC12", "PD2")}
# Latching first, then the rest; by the NVIC's numbers (RM0433 table 149).
PRIORITIES = {28: 0, 29: 0, 78: 0, 11: 0x40, 12: 0x40, 39: 0x40, 49: 0x40, 50: 0x40, 101: 0x40, 122: 0x40, 1: 0x40}
# By ARMv7-M B3.5, from the manual's addresses.
MPU = {0: (0x1FFF8000, 0x1000001D), 1: (0x00000000, 0x0602001F), 2: (0x20000000, 0x130B0021),
       3: (0x24000000, 0x130C0025), 4: (0x30000000, 0x130C0025), 5: (0x38000000, 0x130C002F), 6: (0x08000000, 0x06020029)}


def field(value, low, bits):
    return value >> low & (1 << bits) - 1


def expectations(board, origin, is_v, has_configuration):
    """(what, found, wanted) of every register that matters."""
    at, core = (lambda address: board.values.get(address, 0)), board.core
    cores, timer = (480, 240) if is_v else (400, 200)
    yield "VTOR", core.get(0xED08), origin
    yield "CCR: both caches", field(core.get(0xED14, 0), 16, 2), 3
    yield "SHCSR: the three faults", field(core.get(0xED24, 0), 16, 3), 7
    yield "MPU_CTRL", core.get(0xED94), 7
    for number, words in MPU.items():
        yield f"MPU region {number}", tuple(board.mpu.get(number, (0, 0))), words
    yield "PLL1: crystal, M", (field(at(RCC + 0x28), 0, 2), field(at(RCC + 0x28), 4, 6)), (2, 3)
    divr = at(RCC + 0x30)
    yield "PLL1: N, P, Q", (field(divr, 0, 9) + 1, field(divr, 9, 7) + 1, field(divr, 16, 7) + 1), (cores // 2, 2, 20)
    yield "core = PLL1", field(at(RCC + 0x10), 0, 3), 3
    yield "crystal on and watched, PLL1 on", [at(RCC) >> bit & 1 for bit in (16, 19, 24)], [1, 1, 1]
    yield "HPRE, D1PPRE", (field(at(RCC + 0x18), 0, 4), field(at(RCC + 0x18), 4, 3)), (8, 4)
    yield "D2PPRE1, D2PPRE2", (field(at(RCC + 0x1C), 4, 3), field(at(RCC + 0x1C), 8, 3)), (4, 4)
    yield "D3PPRE", field(at(RCC + 0x20), 4, 3), 4
    yield "USB = HSI48, card = PLL1_Q", (field(at(RCC + 0x54), 20, 2), field(at(RCC + 0x4C), 16, 1)), (3, 0)
    yield "SRAM1 to 3 clocked", field(at(RCC + 0xDC), 29, 3), 7
    yield "VOS", (field(at(PWR + 0x18), 14, 2), at(0x5800042C) & 1), (3, int(is_v))
    # RM0433 table 17: 240 MHz in VOS0 wants 4 wait states, 200 MHz in VOS1 two; more is allowed.
    yield "flash: enough wait states", field(at(0x52002000), 0, 4) >= (4 if is_v else 2), True
    yield "PVD at 2.7 V, backup open", (field(at(PWR), 5, 3), at(PWR) >> 4 & 1, at(PWR) >> 8 & 1), (5, 1, 1)
    for pin, (mode, function) in (PINS | (CAMERA_PINS if has_configuration else {})).items():
        base, n = GPIO[pin[1]], int(pin[2:])
        yield f"{pin} mode", field(at(base), 2 * n, 2), mode
        if function is not None:
            yield f"{pin} function", field(at(base + 0x20 + n // 8 * 4), n % 8 * 4, 4), function
    yield "TIM2, TIM3 PSC", (at(0x40000028), at(0x40000428)), (timer - 1, timer - 1)
    yield "TIM2 ARR, TIM3 ARR", (at(0x4000002C), at(0x4000042C)), (0xFFFFFFFF, 0xFFFF)
    yield "TIM2 CCMR1: TI1, 8 samples", at(0x40000018), 0x31
    yield "TIM2 CCER, DIER, CR2 (enable as TRGO), CR1", [at(0x40000000 + o) for o in (0x20, 0x0C, 0x04, 0)], [1, 2, 0x10, 1]
    yield "TIM3 SMCR: ITR1, trigger mode", at(0x40000408), 0x16
    pulse = timer * 1_000_000 / (at(0x40000828) + 1) / (at(0x4000082C) + 1)
    yield "TIM4: 50 Hz", abs(pulse - 50) < 0.05, True
    baud = cores * 250_000 / max(at(0x4000480C), 1)
    yield "USART3: 921600 baud to 0.5 %", abs(baud / 921_600 - 1) < 0.005, True
    yield "USART3 CR1: on, both ways", at(0x40004800) & 0xD, 0xD
    for irq, priority in PRIORITIES.items():
        yield f"priority of interrupt {irq}", core.get(0xE400 + irq // 4 * 4, 0) >> irq % 4 * 8 & 0xFF, priority
    keys = [value for address, value in board.trace if address == 0x58004800]
    yield "watchdog started, then fed in time", (0xCCCC in keys, keys.count(0xAAAA) >= 3), (True, True)
    if has_configuration:
        yield "TIM1: the sensor's clock", timer / (at(0x4001002C) + 1), 240 / 9 if is_v else 25
        yield "TIM1 on, output on", (at(0x40010000) & 1, at(0x40010044) >> 15 & 1, at(0x40010020) & 1), (1, 1, 1)
        yield "sensor: address", board.sensor.address, 0x5C
        yield "sensor: snapshot mode", board.sensor.registers.get(0x07), 0x0198
        yield "DCMI: one frame, on, capturing", at(0x48020000), 1 << 1 | 1 << 14 | 1
        # Circular, words to words, bursts of four, first priority (RM0433 section 16.5.5); a lap of 32 rows of 512.
        yield "DMA2 stream 1: CR, NDTR, PAR", [at(0x40020428), at(0x4002042C), at(0x40020430)], [0x035501, 4096, 0x48020028]
        yield "DMA2 stream 1: FIFO, into AXI SRAM", (at(0x4002043C) & 7, at(0x40020434) >> 19), (4, 0x24000000 >> 19)
        armed = sum(address == 0x40020434 for address, _ in board.trace)
        yield "a frame armed every 50 ms", abs(armed - board.ticks / 50_000) < 3, True
        yield "DCMI interrupts: line, overrun, frame", at(0x4802000C), 1 << 4 | 1 << 1 | 1 << 0
        yield "DMAMUX1 channel 9 = DCMI", at(0x40020824) & 0x7F, 75
        yield "MDMA channel 0: AXI to DTCM", at(0x52000068) >> 16 & 3, 2
        card = board.card
        yield "card: no command out of order", card.refused, []
        yield "card: 24 MHz, four lines, no interrupt", (at(SDMMC1 + 4) & 0x3FF, at(SDMMC1 + 4) >> 14 & 3, at(SDMMC1 + 0x3C)), (1, 1, 0)
        yield "card: a log from its first block on, whole", logged(card.blocks), []
        yield "card: several writes", card.writes >= 3, True


def logged(blocks):
    """What is wrong with the log on a card: firmware/src/log/block.rs."""
    wrong = [] if sorted(blocks) == list(range(len(blocks))) and blocks else ["blocks are missing"]
    for index, block in sorted(blocks.items()):
        magic, version, _, log, sequence = struct.unpack_from("<4sHHII", block)
        if (magic, version, log, sequence) != (b"PLBL", 2, 0x12345678, index):
            wrong.append(f"block {index}: head {block[:16].hex()}")
        if zlib.crc32(block[:508]) != struct.unpack_from("<I", block, 508)[0]:
            wrong.append(f"block {index}: checksum")
    return wrong[:4]


def main():
    image, origin, revision = sys.argv[1], int(sys.argv[2], 0), int(sys.argv[3], 0)
    board = Board(revision)
    board.load(image)
    if len(sys.argv) > 4:
        board.uc.mem_write(0x08100000, open(sys.argv[4], "rb").read())
    top, reset = struct.unpack("<II", board.uc.mem_read(origin, 8))
    board.uc.reg_write(arm.UC_ARM_REG_SP, top)
    ended = board.run(reset, 3000)
    wrong = [] if ended is None else [f"the program {ended}"]
    record = struct.unpack("<12I", board.uc.mem_read(0x38800008, 48))
    if record[0]:
        wrong.append(f"there is a record of a fault: {' '.join(f'{word:08x}' for word in record)}")
    wanted = list(expectations(board, origin, revision == 0x2003, len(sys.argv) > 4))
    wrong += [f"{what}: {found} instead of {want}" for what, found, want in wanted if found != want]
    print(f"{len(wanted)} registers and fields, {len(board.trace)} writes, {board.ticks / 1e6} s: {len(wrong)} wrong")
    print("\n".join(wrong), end="\n" if wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
