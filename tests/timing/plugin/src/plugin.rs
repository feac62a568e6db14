//! QEMU's side. Only what is used of its plugin interface is declared here, since Debian ships no header for it.
//!
//! Interface versions: QEMU 6 to 8 take plugins of version 0 or 1, QEMU 9.0 and newer of 2 at least (9.0 is 2, 9.1 is 3,
//! 9.2 and 10.0 are 4, 10.1 is 5, later ones 6 and more, all with 2 as the oldest they take). What went with version 2
//! are the inline counters and the number of virtual processors, what changed with 3 is how an instruction's bytes are
//! read: none of these is used, so one library serves all, if only it claims the right version. [`claim`] sees to that.
//! Tried: Debian's 7.2.22 and
//! 10.0.2, which wrote the same file byte for byte.

#![allow(unsafe_code, reason = "a foreign interface")]

use crate::decode::{Instruction, Marker, decode, is_wide};
use crate::image::Image;
use crate::regions::{Regions, StretchId, header};
use std::cell::UnsafeCell;
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::fs::File;
use std::io::Write;
use std::sync::atomic::{AtomicI32, Ordering};

/// A block of translated code, and an instruction in it: QEMU's own.
#[repr(C)]
struct Block(c_void);
#[repr(C)]
struct BlockInstruction(c_void);

type ExecutedCallback = extern "C" fn(c_uint, *mut c_void);
type AccessCallback = extern "C" fn(c_uint, u32, u64, *mut c_void);

/// The callbacks read no registers.
const NO_REGISTERS: c_int = 0;
const READS_AND_WRITES: c_int = 3;

unsafe extern "C" {
    fn qemu_plugin_register_vcpu_tb_trans_cb(id: u64, callback: extern "C" fn(u64, *const Block));
    fn qemu_plugin_tb_n_insns(block: *const Block) -> usize;
    fn qemu_plugin_tb_get_insn(block: *const Block, index: usize) -> *mut BlockInstruction;
    fn qemu_plugin_insn_vaddr(instruction: *const BlockInstruction) -> u64;
    fn qemu_plugin_register_vcpu_insn_exec_cb(
        instruction: *mut BlockInstruction,
        callback: ExecutedCallback,
        flags: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_register_vcpu_mem_cb(
        instruction: *mut BlockInstruction,
        callback: AccessCallback,
        flags: c_int,
        which: c_int,
        data: *mut c_void,
    );
    fn qemu_plugin_mem_is_store(info: u32) -> bool;
    fn qemu_plugin_mem_size_shift(info: u32) -> c_uint;
    fn dlsym(library: *mut c_void, name: *const c_char) -> *mut c_void;
}

/// The version that the library claims, read by QEMU before it calls anything.
#[allow(non_upper_case_globals, reason = "the name QEMU asks for")]
#[unsafe(no_mangle)]
pub static qemu_plugin_version: AtomicI32 = AtomicI32::new(1);

/// Runs while the library is loaded, before QEMU reads the version.
#[used]
#[unsafe(link_section = ".init_array")]
static CLAIM: extern "C" fn() = claim;

/// Claims version 2 of an emulator that has what came with it.
extern "C" fn claim() {
    // SAFETY: null asks for any symbol of the process, the name is a C string.
    let scoreboard = unsafe { dlsym(std::ptr::null_mut(), c"qemu_plugin_scoreboard_new".as_ptr()) };
    if !scoreboard.is_null() {
        qemu_plugin_version.store(2, Ordering::Relaxed);
    }
}

struct Plugin {
    image: Image,
    out: File,
    regions: Regions,
}

/// The one plugin, there from `qemu_plugin_install` on.
struct Global(UnsafeCell<Option<Plugin>>);

// SAFETY: the board has one processor, and QEMU translates for it and executes it in one thread.
unsafe impl Sync for Global {}

static PLUGIN: Global = Global(UnsafeCell::new(None));

/// Lends the plugin to a callback.
fn with<R>(work: impl FnOnce(&mut Plugin) -> R) -> Option<R> {
    // SAFETY: callbacks come one after the other from one thread, and none of them calls another.
    unsafe { &mut *PLUGIN.0.get() }.as_mut().map(work)
}

/// Where QEMU begins. 0: the plugin stays.
///
/// # Safety
/// `argv` holds `argc` C strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn qemu_plugin_install(
    id: u64,
    _info: *const c_void,
    argc: c_int,
    argv: *const *const c_char,
) -> c_int {
    let count = usize::try_from(argc).unwrap_or(0);
    // SAFETY: the caller's promise.
    let arguments = (0..count).map(|n| unsafe { CStr::from_ptr(*argv.add(n)) }.to_string_lossy().into_owned());
    match open(arguments) {
        Ok(plugin) => {
            // SAFETY: no callback is registered yet.
            unsafe { *PLUGIN.0.get() = Some(plugin) };
            // SAFETY: `id` is ours, and the callback lives as long as the library.
            unsafe { qemu_plugin_register_vcpu_tb_trans_cb(id, translated) };
            0
        }
        Err(why) => {
            eprintln!("plumbline-cost: {why}");
            -1
        }
    }
}

fn open(arguments: impl Iterator<Item = String>) -> Result<Plugin, String> {
    let (mut image, mut out) = (None, None);
    for argument in arguments {
        match argument.split_once('=') {
            Some(("image", path)) => image = Some(path.to_owned()),
            Some(("out", path)) => out = Some(path.to_owned()),
            _ => return Err(format!("unknown argument {argument:?}; wanted are image=ELF and out=FILE")),
        }
    }
    let (image, out) = image.zip(out).ok_or("image=ELF and out=FILE are wanted")?;
    let bytes = std::fs::read(&image).map_err(|error| format!("{image}: {error}"))?;
    let parsed = Image::parse(&bytes).ok_or_else(|| format!("{image} is no 32-bit little-endian ELF file"))?;
    let mut file = File::create(&out).map_err(|error| format!("{out}: {error}"))?;
    writeln!(file, "{}", header()).map_err(|error| format!("{out}: {error}"))?;
    Ok(Plugin { image: parsed, out: file, regions: Regions::default() })
}

/// A piece of code that cannot be counted ends the run: a count with a hole would look like an improvement.
fn give_up(why: &str) -> ! {
    eprintln!("plumbline-cost: {why}");
    std::process::exit(3)
}

/// Cuts a block into stretches and markers, and has both tell when they are executed.
extern "C" fn translated(_id: u64, block: *const Block) {
    // SAFETY: `block` lives as long as this call.
    let count = unsafe { qemu_plugin_tb_n_insns(block) };
    let mut stretch: Vec<(*mut BlockInstruction, u32, Instruction)> = Vec::new();
    for n in 0..count {
        // SAFETY: `n` is below the number of instructions, which live as long as the block.
        let (handle, address) = unsafe {
            let handle = qemu_plugin_tb_get_insn(block, n);
            (handle, qemu_plugin_insn_vaddr(handle) as u32)
        };
        let instruction = with(|plugin| read(&plugin.image, address)).flatten();
        let Some(instruction) = instruction else {
            give_up(&format!("no code of the image lies at {address:#010x}"));
        };
        if let Some(marker) = instruction.marker {
            close(&mut stretch);
            let data = match marker {
                Marker::Begin => 1,
                Marker::End => 2,
            };
            // SAFETY: as above; the data is a number.
            unsafe { qemu_plugin_register_vcpu_insn_exec_cb(handle, marked, NO_REGISTERS, data as *mut c_void) };
        } else {
            stretch.push((handle, address, instruction));
            // SAFETY: as above.
            unsafe {
                qemu_plugin_register_vcpu_mem_cb(
                    handle,
                    accessed,
                    NO_REGISTERS,
                    READS_AND_WRITES,
                    std::ptr::null_mut(),
                );
            }
        }
    }
    close(&mut stretch);
}

fn read(image: &Image, address: u32) -> Option<Instruction> {
    let first = image.half(address)?;
    let second = if is_wide(first) { image.half(address + 2)? } else { 0 };
    Some(decode(first, second))
}

fn close(stretch: &mut Vec<(*mut BlockInstruction, u32, Instruction)>) {
    let Some(&(first, ..)) = stretch.first() else { return };
    let instructions: Vec<_> = stretch.drain(..).map(|(_, address, instruction)| (address, instruction)).collect();
    let id: StretchId = with(|plugin| plugin.regions.stretch(&instructions)).unwrap_or(0);
    // SAFETY: the instruction belongs to the block being translated; the data is a number.
    unsafe { qemu_plugin_register_vcpu_insn_exec_cb(first, entered, NO_REGISTERS, id as *mut c_void) };
}

extern "C" fn entered(_processor: c_uint, id: *mut c_void) {
    with(|plugin| plugin.regions.enter(id as StretchId));
}

extern "C" fn accessed(_processor: c_uint, info: u32, address: u64, _data: *mut c_void) {
    // SAFETY: plain functions of the number that QEMU gave.
    let (bytes, is_store) = unsafe { (1 << qemu_plugin_mem_size_shift(info), qemu_plugin_mem_is_store(info)) };
    with(|plugin| plugin.regions.access(address as u32, bytes, is_store));
}

extern "C" fn marked(_processor: c_uint, data: *mut c_void) {
    let marker = if data as usize == 1 { Marker::Begin } else { Marker::End };
    let written = with(|plugin| match plugin.regions.mark(marker) {
        Ok(None) => Ok(()),
        Ok(Some(line)) => writeln!(plugin.out, "{line}").map_err(|error| error.to_string()),
        Err(why) => Err(why.to_owned()),
    });
    if let Some(Err(why)) = written {
        give_up(&why);
    }
}
