"""An SD card behind SDMMC1, as the rehearsal's board sees it: RM0433 55.10 for the registers, the SD specification 4.3 and 4.10
for the card. It answers only what a card in its state answers, so a driver that takes a step out of order finds no card."""

BASE = 0x52007000
ARG, CMD, RESP, DLEN, DCTRL, STA, ICR, MASK, IDMACTRL, IDMABASE = 0x08, 0x0C, 0x14, 0x28, 0x2C, 0x34, 0x38, 0x3C, 0x50, 0x58
CTIMEOUT, CMDREND, CMDSENT, DATAEND = 1 << 2, 1 << 6, 1 << 7, 1 << 8
IDLE, READY, IDENT, STANDBY, TRANSFER, PROGRAMMING = 0, 1, 2, 3, 4, 7
ADDRESS = 0xAAAA0000
BLOCKS = 2048
# CSD version 2: C_SIZE 1, so 2 * 512 KiB.
CSD = [0x400E0032, 0x5B590000, 0x00017F80, 0x0A404013]


class Card:
    """Gets ready at the third asking, and is busy for two after each write."""

    def __init__(self, uc):
        self.uc, self.blocks, self.state, self.is_application = uc, {}, IDLE, False
        self.flags, self.response, self.asked, self.busy, self.refused, self.writes = 0, [0] * 4, 0, 0, [], 0

    def write(self, offset, value, values):
        if offset == ICR:
            self.flags &= ~value
        if offset == CMD and value >> 12 & 1:
            self.command(value & 0x3F, value, values)

    def read(self, offset, value):
        if offset == STA:
            return self.flags
        if RESP <= offset < RESP + 16:
            return self.response[(offset - RESP) // 4]
        return value

    def status(self):
        return (self.state << 9) | (self.state == TRANSFER) << 8

    def command(self, number, word, values):
        argument = values.get(BASE + ARG, 0)
        is_application, self.is_application = self.is_application, False
        waits, is_data, is_stop = word >> 8 & 3, word >> 6 & 1, word >> 7 & 1
        answer, was = None, self.status()
        if number == 0:
            self.__init_state()
            self.flags |= CMDSENT
            return
        if number == 8 and self.state == IDLE:
            answer = argument
        elif number == 55 and argument in (0, ADDRESS):
            self.is_application, answer = True, was | 1 << 5
        elif number == 41 and is_application and self.state == IDLE and argument >> 30 & 1:
            self.asked += 1
            answer = 0xC0FF8000 if self.asked >= 3 else 0x00FF8000
            self.state = READY if self.asked >= 3 else IDLE
        elif number == 2 and self.state == READY and waits == 3:
            self.state, answer = IDENT, 0
        elif number == 3 and self.state == IDENT:
            self.state, answer = STANDBY, ADDRESS | 0x500
        elif number == 9 and self.state == STANDBY and argument == ADDRESS and waits == 3:
            self.response, self.flags = list(CSD), self.flags | CMDREND
            return
        elif number == 7 and self.state == STANDBY and argument == ADDRESS:
            self.state, answer = TRANSFER, was
        elif number == 6 and is_application and self.state == TRANSFER and argument == 2:
            answer = was
        elif number == 13 and argument == ADDRESS:
            answer = was
            if self.state == PROGRAMMING:
                self.busy -= 1
                self.state = PROGRAMMING if self.busy else TRANSFER
        elif number == 16 and self.state == TRANSFER and argument == 512:
            answer = was
        elif number in (18, 25) and self.state == TRANSFER and is_data and values.get(BASE + IDMACTRL, 0) & 1:
            answer, self.state = was, 5 if number == 18 else 6
            self.move(number == 18, argument, values)
        elif number == 12 and is_stop and self.state in (5, 6):
            answer = was
            self.state, self.busy = (TRANSFER, 0) if self.state == 5 else (PROGRAMMING, 2)
        if answer is None:
            self.refused.append((number, self.state))
            self.flags |= CTIMEOUT
        else:
            self.response, self.flags = [answer, 0, 0, 0], self.flags | CMDREND

    def __init_state(self):
        self.state, self.asked, self.is_application = IDLE, 0, False

    def move(self, is_read, index, values):
        memory, length = values.get(BASE + IDMABASE, 0), values.get(BASE + DLEN, 0)
        control = values.get(BASE + DCTRL, 0)
        is_fit = control >> 1 & 1 == is_read and control >> 4 & 15 == 9 and length % 512 == 0
        # This DMA reaches AXI SRAM alone.
        if not is_fit or not 0x24000000 <= memory < 0x24080000 or memory % 4:
            self.refused.append(("data", control, memory, length))
            return
        for n in range(length // 512):
            if is_read:
                self.uc.mem_write(memory + 512 * n, self.blocks.get(index + n, bytes(512)))
            else:
                self.blocks[index + n] = bytes(self.uc.mem_read(memory + 512 * n, 512))
        self.writes += not is_read
        self.flags |= DATAEND
