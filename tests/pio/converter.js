// A model of TI's ADS7953 by its data sheet, SLAS605: frames, modes, and times that it needs and takes.
"use strict";

/** Times in ns, each at the supply for which it is worst. */
const CS_TO_DATA = 38; // t_d1, at most
const CLOCK_TO_NEXT_BIT = 35; // t_d2, at most
const BIT_HOLD = 3; // t_h1, at least
const CLOCK_TO_FREE = 26; // t_d3: from the sixteenth falling edge until SDO is free, at most
const CS_TO_CLOCK = 8; // t_su1, at least
const COMMAND_SETUP = 4; // t_su2, at least
const COMMAND_HOLD = 12; // t_h2, at least
const CS_HIGH = 20; // t_w1, at least
const QUIET = 40; // t_q: SDO is free before the next frame, at least
const ACQUISITION = 325; // at least
const CLOCK_LOW = 20; // at least
const CLOCK_HIGH = 20; // at least
const CLOCK_PERIOD = 50; // at least
const BITS = 16;
const CHANNELS = 16;

class Converter {
  /**
   * @param core_hz clock in which times are given
   * @param before  mode before the first frame: `auto`, or manual; `last` channel of a pass; `channel` that was chosen last
   */
  constructor(core_hz, before = {}) {
    this.nanoseconds = (cycles) => (cycles * 1e9) / core_hz;
    const { auto = false, last = CHANNELS - 1, channel = 0 } = before;
    Object.assign(this, { auto, last });
    // A frame's command chooses a channel; in the next frame the multiplexer goes there; in the one after it is sent.
    this.chosen = this.multiplexer = channel;
    this.conversions = 0;
    /** Complete frames: channel, word and command, and the core cycles of all edges. */
    this.frames = [];
    this.frame = undefined;
    /** The data line: its levels, each with the time from which it is uncertain, and that from which it is valid, in ns. */
    this.line = [{ from: -Infinity, valid: -Infinity, level: true }];
    /** Shortest time for which the data line was valid before it was sampled, ns. */
    this.margin = Infinity;
    /** Edges of the time before, ns. */
    this.last_edge = { cs_rise: -Infinity, sclk_rise: -Infinity, sclk_fall: -Infinity, sdi: -Infinity, free: -Infinity };
    this.faults = [];
    /** True while a frame may end early: the machine was stopped. */
    this.may_abort = false;
  }

  fault(text) {
    this.faults.push(text);
  }

  /** Faults when less than `least` ns have passed since the edge. */
  since(edge, least, now, what) {
    const passed = now - edge;
    if (passed < least) this.fault(`${what}: ${passed.toFixed(1)} ns instead of ${least} ns`);
  }

  /** The level of the data line at this time. */
  level(cycles) {
    const time = this.nanoseconds(cycles);
    return this.line.findLast(({ from }) => from <= time).level;
  }

  /** Notes that the line is sampled at this time. */
  sample(cycles) {
    const time = this.nanoseconds(cycles);
    const { valid } = this.line.findLast(({ from }) => from <= time);
    this.margin = Math.min(this.margin, time - valid);
    if (time < valid) this.fault(`SDO is sampled ${(valid - time).toFixed(1)} ns before it is valid`);
  }

  /** The pins change at this time. */
  change(cycles, before, after) {
    const time = this.nanoseconds(cycles);
    const [cs, sclk, sdi] = ["cs", "sclk", "sdi"].map((name) => before[name] !== after[name]);
    if (cs && sclk && !this.may_abort) this.fault("CS and SCLK change at the same time");
    if (sclk && before.cs && after.cs) this.fault("SCLK changes while CS is high");
    if (sdi) {
      this.since(this.last_edge.sclk_rise, COMMAND_HOLD, time, "hold time of SDI");
      this.last_edge.sdi = time;
    }
    if (cs && !after.cs) this.begin(cycles, time);
    if (sclk && !after.cs) {
      if (after.sclk) this.rise(cycles, time, after.sdi);
      else this.fall(cycles, time);
    }
    if (cs && after.cs) this.end(cycles, time);
  }

  begin(cycles, time) {
    this.since(this.last_edge.cs_rise, CS_HIGH, time, "CS high");
    this.since(this.last_edge.cs_rise, ACQUISITION, time, "acquisition");
    this.since(this.last_edge.free, QUIET, time, "quiet time");
    const channel = this.multiplexer;
    this.multiplexer = this.chosen;
    // Another code in each conversion, so that no two frames of a test are alike.
    const code = Math.imul(++this.conversions, 0x9e3779b1) >>> 20;
    const word = (channel << 12) | code;
    this.frame = { channel, word, command: 0, fall: cycles, rises: [], falls: [] };
    this.fell = time;
    this.present(word >>> (BITS - 1), time, time + CS_TO_DATA);
  }

  present(bit, from, valid) {
    this.line = [...this.line.slice(-2), { from, valid, level: (bit & 1) === 1 }];
  }

  rise(cycles, time, bit) {
    this.since(this.fell, CS_TO_CLOCK, time, "CS low before the first clock");
    this.since(this.last_edge.sclk_fall, CLOCK_LOW, time, "SCLK low");
    this.since(this.last_edge.sclk_rise, CLOCK_PERIOD, time, "period of SCLK");
    this.since(this.last_edge.sdi, COMMAND_SETUP, time, "setup time of SDI");
    this.last_edge.sclk_rise = time;
    this.frame.rises.push(cycles);
    this.frame.command = ((this.frame.command << 1) | (bit ? 1 : 0)) & 0xffff;
  }

  fall(cycles, time) {
    this.since(this.last_edge.sclk_rise, CLOCK_HIGH, time, "SCLK high");
    this.last_edge.sclk_fall = time;
    const { falls, word } = this.frame;
    falls.push(cycles);
    if (falls.length < BITS) {
      this.present(word >>> (BITS - 1 - falls.length), time + BIT_HOLD, time + CLOCK_TO_NEXT_BIT);
    } else {
      this.release(time + CLOCK_TO_FREE);
    }
  }

  /** The pull-up of the chip holds the line while the converter does not drive it. */
  release(free) {
    this.present(1, free, free);
    this.last_edge.free = free;
  }

  end(cycles, time) {
    const { frame } = this;
    const [rises, falls] = [frame.rises.length, frame.falls.length];
    this.last_edge.cs_rise = time;
    this.frame = undefined;
    if (rises === BITS && falls === BITS) {
      this.frames.push({ ...frame, rise: cycles });
      this.execute(frame.command);
    } else {
      this.release(time + CLOCK_TO_FREE);
      if (!this.may_abort) this.fault(`a frame with ${rises} rising and ${falls} falling edges of SCLK before CS rises`);
    }
    this.may_abort = false;
  }

  /** Executes the command of a frame. */
  execute(command) {
    if (this.auto) this.chosen = this.chosen >= this.last ? 0 : this.chosen + 1;
    const is_valid = (command & (1 << 11)) !== 0;
    switch (command >>> 12) {
      case 0b0000: // Continue.
        break;
      case 0b0001: // Manual.
        this.auto = false;
        if (is_valid) this.chosen = (command >>> 7) & 0xf;
        break;
      case 0b0011: // Auto-2.
        this.auto = true;
        if (is_valid && command & (1 << 10)) this.chosen = 0;
        if (is_valid && command & 0b111_0000) this.fault(`range, power-down or GPIO are set: ${command.toString(16)}`);
        break;
      case 0b1001: // Program Auto-2.
        this.last = (command >>> 6) & 0xf;
        break;
      default:
        this.fault(`a command that the firmware does not use: ${command.toString(16)}`);
    }
  }
}

module.exports = { Converter };
