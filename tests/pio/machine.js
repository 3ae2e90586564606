// The state machine in the emulator, set up as boards/pico2/src/chip/adc.rs does it.
//
// The emulated chip is an RP2040. Its PIO is version 0, of which version 1 in the RP2350 is a superset: this program has only
// instructions and settings that both have.
//
// What the emulator leaves out is done here. It executes an instruction with all its delay at once: the time is its count of
// cycles, to which this adds those of a machine that waits. It has no clock divider: a cycle counts as DIVIDER core cycles.
// It has no synchroniser of the inputs: see `INPUT_DELAY`. It also steps machines that are not enabled: only machine 0 is
// stepped. A new setting of the joined FIFOs does not clear them: they are read until they are empty.
"use strict";
const { RP2040, GPIOPinState } = require("rp2040js");

const IO_BANK0 = 0x40014000;
const PADS_BANK0 = 0x4001c000;
const PIO0 = 0x50200000;
const CTRL = PIO0;
const FSTAT = PIO0 + 0x004;
const FDEBUG = PIO0 + 0x008;
const TXF0 = PIO0 + 0x010;
const RXF0 = PIO0 + 0x020;
const INSTR_MEM0 = PIO0 + 0x048;
const SM0_CLKDIV = PIO0 + 0x0c8;
const SM0_EXECCTRL = PIO0 + 0x0cc;
const SM0_SHIFTCTRL = PIO0 + 0x0d0;
const SM0_INSTR = PIO0 + 0x0d8;
const SM0_PINCTRL = PIO0 + 0x0dc;
const SM0_RX_EMPTY = 1 << 8;
const SM0_RX_STALL = 1;
const SM0_RESTART = 1 << 4;
const FUNCTION_PIO0 = 6;
const PAD_INPUT = 1 << 6;
const PAD_PULL_UP = 1 << 3;
const SET_PINS = 0b111_00000_000_00000;
const SET_PIN_DIRECTIONS = 0b111_00000_100_00000;

/** Core cycles by which the machine sees an input late: the two flip-flops of its synchroniser, INPUT_SYNC_BYPASS being 0. */
const INPUT_DELAY = 2;

/** The parts of an instruction, with two bits of side-set. */
const decode = (word) => ({ operation: word >>> 13, side: (word >>> 11) & 3, delay: (word >>> 8) & 7, operand: word & 0xff });
function encode({ operation, side, delay, operand }) {
  if (side > 3 || delay > 7 || operand > 0xff) throw new Error("an instruction has no room for this");
  return (operation << 13) | (side << 11) | (delay << 8) | operand;
}
const IN = 0b010;

class Machine {
  /** @param converter gets each change of the pins, and answers with the level of the data line; times are in core cycles */
  constructor({ program, plan, pins }, converter) {
    if (program.side_set_bits !== 2 || pins.cs !== pins.sclk + 1) throw new Error("the side-set is not the clock and above it CS");
    Object.assign(this, { program, pins, converter, divider: plan.divider });
    /** Cycles of the state machine since it was first enabled. */
    this.cycle = 0;
    this.chip = new RP2040();
    this.state = this.chip.pio[0].machines[0];
    const write = (address, value) => this.chip.writeUint32(address, value >>> 0);
    program.words.forEach((word, k) => write(INSTR_MEM0 + 4 * k, word));
    for (const pin of Object.values(pins)) {
      write(PADS_BANK0 + 4 + 4 * pin, PAD_INPUT | (pin === pins.sdo ? PAD_PULL_UP : 0));
      write(IO_BANK0 + 4 + 8 * pin, FUNCTION_PIO0);
    }
    write(SM0_CLKDIV, plan.divider << 16);
    write(SM0_EXECCTRL, (program.wrap.source << 12) | (program.wrap.target << 7));
    write(SM0_SHIFTCTRL, 0); // Both to the left, without autopush and autopull.
    const set = (instruction, level, names) => {
      for (const name of names) {
        write(SM0_PINCTRL, (1 << 26) | (pins[name] << 5));
        write(SM0_INSTR, instruction | level);
      }
    };
    set(SET_PINS, 1, ["cs"]);
    set(SET_PINS, 0, ["sclk", "sdi"]);
    set(SET_PIN_DIRECTIONS, 1, ["sclk", "cs", "sdi"]);
    write(SM0_PINCTRL, (2 << 29) | (1 << 20) | (pins.sdo << 15) | (pins.sclk << 10) | pins.sdi);
    this.levels = this.readPins();
  }

  /** Starts at the first word with these commands in the FIFO, from any state. */
  start(commands) {
    this.chip.writeUint32(CTRL, SM0_RESTART);
    while (this.readFrame() !== undefined);
    this.chip.writeUint32(SM0_INSTR, 0); // `jmp 0`
    for (const command of commands) this.chip.writeUint32(TXF0, (command << 16) >>> 0);
    this.counted = this.state.cycles;
  }

  /** Executes an instruction, or waits for a cycle. */
  step() {
    this.count();
    const { state, converter, cycle } = this;
    const waited = state.waiting;
    const seen = cycle * this.divider - INPUT_DELAY;
    if (!waited && decode(this.program.words[state.pc] ?? 0).operation === IN) converter.sample(seen);
    this.chip.gpio[this.pins.sdo].setInputValue(converter.level(seen));
    state.step();
    this.chip.pio[0].checkChangedPins();
    if (waited && state.waiting) this.cycle += 1;
    this.count();
    const levels = this.readPins();
    if (["cs", "sclk", "sdi"].some((name) => levels[name] !== this.levels[name])) {
      converter.change(cycle * this.divider, this.levels, levels);
      this.levels = levels;
    }
  }

  /** Adds the cycles that the emulator has counted. */
  count() {
    this.cycle += this.state.cycles - this.counted;
    this.counted = this.state.cycles;
  }

  readPins() {
    const level = (name) => {
      const { value } = this.chip.gpio[this.pins[name]];
      if (value !== GPIOPinState.High && value !== GPIOPinState.Low) throw new Error(`${name} is not an output`);
      return value === GPIOPinState.High;
    };
    return { cs: level("cs"), sclk: level("sclk"), sdi: level("sdi") };
  }

  /** The next word of the FIFO, if there is one. */
  readFrame() {
    if (this.chip.readUint32(FSTAT) & SM0_RX_EMPTY) return undefined;
    return this.chip.readUint32(RXF0) >>> 0;
  }

  /** True when the machine had to wait for room: what the firmware reports as lost scans. */
  get overrun() {
    return (this.chip.readUint32(FDEBUG) & SM0_RX_STALL) !== 0;
  }

  get waits() {
    return this.state.waiting;
  }
}

module.exports = { Machine, decode, encode };
