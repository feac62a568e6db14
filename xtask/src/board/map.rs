//! The flight computer's banks, as the check knows them: from the chip's manual (RM0433, table 7), not from memory.x.

use std::ops::Range;

/// Instructions, no wait states.
pub const ITCM: Range<u32> = 0x0000_0000..0x0001_0000;
/// Data, no wait states.
pub const DTCM: Range<u32> = 0x2000_0000..0x2002_0000;
/// On the AXI bus, all DMA.
pub const AXI: Range<u32> = 0x2400_0000..0x2408_0000;
/// SRAM1 to SRAM3.
pub const SRAM123: Range<u32> = 0x3000_0000..0x3004_8000;
/// Kept over a reset.
pub const BACKUP: Range<u32> = 0x3880_0000..0x3880_1000;
/// Start of flash, and of the camera's bootloader.
pub const BANK_1: u32 = 0x0800_0000;
/// Where that bootloader starts the application.
pub const APPLICATION: u32 = 0x0804_0000;
/// Start of the configuration and the tiles.
pub const BANK_2: u32 = 0x0810_0000;
/// What static data and stack may take without drivers and frame, bytes. The paper's 25 KB hold on the emulated board; here the
/// journal, the pilot's lines and the link to a real autopilot come on top.
pub const RAM_LIMIT: u32 = 32 * 1024;
/// What the image may take of flash, bytes.
pub const FLASH_LIMIT: u32 = 512 * 1024;

/// Sections that must be there, and where.
pub const SECTIONS: [(&str, Range<u32>); 8] = [
    (".itcm", ITCM),
    (".data", DTCM),
    (".bss", DTCM),
    (".uninit", AXI),
    (".axisram", AXI),
    (".sram123", SRAM123),
    (".backup", BACKUP),
    (".text", BANK_1..BANK_2),
];

/// Buffers that must be there, by the end of their mangled names' paths, and where. DMA1 and DMA2 do not reach DTCM, the
/// card's DMA reaches AXI SRAM alone; what the pipeline works in must not wait for a bus.
pub const BUFFERS: [(&str, Range<u32>); 24] = [
    ("9front_end4RING", AXI),
    ("4card6BLOCKS", AXI),
    ("7logging4RING", SRAM123),
    ("7logging3LOG", DTCM),
    ("4link4SEND", SRAM123),
    ("4link7RECEIVE", SRAM123),
    ("5fault6RECORD", BACKUP),
    ("5fault4MODE", BACKUP),
    ("5fault5BOOTS", BACKUP),
    ("4kept5STAMP", BACKUP),
    ("4kept5ARMED", BACKUP),
    ("9simulator5WIRES", SRAM123),
    ("9simulator7SESSION", SRAM123),
    ("9simulator11MEMORY_ROWS", SRAM123),
    ("9simulator20MEMORY_CONFIGURATION", SRAM123),
    ("9simulator11MEMORY_PLAN", SRAM123),
    ("9simulator10MEMORY_KEY", SRAM123),
    ("9simulator12MEMORY_TILES", AXI),
    ("4boot12FRAME_MEMORY", DTCM),
    ("4boot7BUFFERS", DTCM),
    ("4boot10NAVIGATION", DTCM),
    ("4boot3APP", DTCM),
    ("6flight7STAGING", DTCM),
    ("FAULT_STACK", DTCM),
];

/// Statics that the emulated board has too: what the budget of 32 KiB is about. The rest is drivers', and what is kept of
/// a frame.
pub const COMPARABLE: [&str; 10] = [
    "4boot3APP",
    "4boot7BUFFERS",
    "4boot10NAVIGATION",
    "5tasks7receive4POOL",
    "5tasks6camera4POOL",
    "5tasks8transmit4POOL",
    "5tasks4beat4POOL",
    "5tasks6pulses4POOL",
    "5tasks5edges4POOL",
    "5start8EXECUTOR",
];
