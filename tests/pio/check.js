// check.js PROGRAM.json: runs the program of the PIO against a model of the converter. Prints one line; exits with 1 when
// something is wrong, or when a program that is wrong on purpose is not noticed.
"use strict";
const fs = require("node:fs");
const path = require("node:path");
const { Machine } = require("./machine.js");
const { Converter } = require("./converter.js");
const { mutants } = require("./mutants.js");

/** States of the converter before a start: after power-up, and as another program may leave it. */
const STATES = [{}, { channel: 7 }, { auto: true, channel: 12 }, { auto: true, last: 4, channel: 3 }];
/** Words that fit into the FIFO. */
const FIFO_DEPTH = 4;
/** Frames after a command until its channel is received. */
const PIPELINE = 2;

class Fault extends Error {}
function require_that(is_so, text) {
  if (!is_so) throw new Fault(text);
}

/** A machine with a converter, started. */
function started(description, state) {
  const converter = new Converter(description.plan.core_hz, state);
  const machine = new Machine(description, converter);
  machine.start(description.commands);
  return { machine, converter };
}

/** Cycles of a frame by the plan. */
const frameCycles = ({ gap, low, high, frame_bits, hold }) => gap + frame_bits * (low + high) + hold;

/** Executes an instruction or waits for a cycle; the converter must have nothing against it. */
function step({ machine, converter }) {
  machine.step();
  require_that(converter.faults.length === 0, converter.faults[0]);
}

/** Steps until `count` frames are received; `read` is asked in each step whether the FIFO is read. */
function receive(pair, count, limit, read = () => true) {
  const { machine } = pair;
  const received = [];
  const end = machine.cycle + limit;
  while (received.length < count) {
    step(pair);
    require_that(machine.cycle < end, `${received.length} frames in ${limit} cycles`);
    if (!read(machine)) continue;
    const word = machine.readFrame();
    if (word !== undefined) received.push(word);
  }
  return received;
}

/** Cycles within which frames must come; that they come on time is checked by their edges. */
const limit = (plan, count) => 2 * (count + 2) * frameCycles(plan);

/** The words are those that the converter sent, and the channels come in order. */
function checkFrames({ plan, commands, frames_to_start }, { converter }, received, { from = 0 } = {}) {
  const frames = converter.frames.slice(from);
  received.forEach((word, k) => {
    const sent = frames[k];
    require_that(sent !== undefined, `frame ${k} is received before it ends`);
    require_that(word === sent.word, `frame ${k}: ${word.toString(16)} is received, ${sent.word.toString(16)} was sent`);
    require_that(sent.command === (commands[k] ?? 0), `frame ${k} has the command ${sent.command.toString(16)}`);
    const after = k - (commands.length - 1) - PIPELINE;
    require_that(after < 0 || word >>> 12 === after % plan.channels, `frame ${k} is of channel ${word >>> 12}`);
  });
  const first_pass = commands.length - 1 + PIPELINE + plan.channels;
  require_that(first_pass <= commands.length + frames_to_start, "the first pass ends too late for the firmware");
}

/** Every edge is where the plan has it, in cycles of the state machine. After a wait a gap may be longer. */
function checkTimes({ plan }, { converter }, { may_wait = false } = {}) {
  const period = frameCycles(plan);
  const seconds = (period * plan.divider * plan.channels * plan.ratio * plan.rate_hz) / plan.core_hz;
  require_that(seconds === 1, `a second of scans takes ${seconds} s`);
  const equal = (core_cycles, cycles, what) =>
    require_that(core_cycles === cycles * plan.divider, `${what}: ${core_cycles / plan.divider} instead of ${cycles} cycles`);
  converter.frames.forEach(({ fall, rise, rises, falls }, k) => {
    rises.forEach((up, bit) => {
      equal(up - (falls[bit - 1] ?? fall), plan.low, "SCLK low");
      equal(falls[bit] - up, plan.high, "SCLK high");
    });
    require_that(falls.length === plan.frame_bits, `${falls.length} clocks`);
    equal(rise - falls.at(-1), plan.hold, "hold of CS after the last falling edge");
    const before = converter.frames[k - 1];
    const gap = k === 0 ? fall : fall - before.rise;
    const may_be_longer = k === 0 || may_wait;
    if (!may_be_longer || gap < plan.gap * plan.divider) equal(gap, plan.gap, "CS high");
    if (!may_be_longer) equal(fall - before.fall, period, "period of CS");
  });
}

/** Frames from each state of the converter, read at once. */
function checkRunning(description) {
  const { plan } = description;
  const count = 12 * plan.channels;
  let margin = Infinity;
  for (const state of STATES) {
    const pair = started(description, state);
    const received = receive(pair, count, limit(plan, count));
    checkFrames(description, pair, received);
    checkTimes(description, pair);
    require_that(!pair.machine.overrun, "an overrun, although the FIFO was read");
    margin = Math.min(margin, pair.converter.margin);
  }
  return { count: STATES.length * count, margin };
}

/** Steps until the machine waits because nobody reads the FIFO, and then for a while. */
function stall(pair, { plan }) {
  const { machine, converter } = pair;
  const end = machine.cycle + limit(plan, FIFO_DEPTH + 1);
  while (!machine.waits) {
    step(pair);
    require_that(machine.cycle < end, "the machine does not wait for room");
  }
  for (let cycle = 0; cycle < 10 * frameCycles(plan); cycle++) {
    step(pair);
    require_that(machine.waits && machine.levels.cs && !machine.levels.sclk, "the machine waits with CS low or SCLK high");
  }
  require_that(converter.frames.length === FIFO_DEPTH + 1, `it waits after ${converter.frames.length} frames`);
  require_that(machine.overrun, "the firmware does not see that the machine waits");
}

/** Nobody reads the FIFO; then it is read. */
function checkStall(description) {
  const { plan } = description;
  const pair = started(description);
  stall(pair, description);
  const count = 4 * plan.channels;
  const received = receive(pair, count, limit(plan, count));
  checkFrames(description, pair, received);
  checkTimes(description, pair, { may_wait: true });
}

/** Every frame is read later than the next one comes. */
function checkSlowReader(description) {
  const { plan } = description;
  const pair = started(description);
  const count = 4 * plan.channels;
  const pause = 3 * frameCycles(plan) - 1;
  let next = pause;
  const read = ({ cycle }) => cycle >= next && ((next = cycle + pause), true);
  const received = receive(pair, count, 4 * limit(plan, count), read);
  checkFrames(description, pair, received);
  checkTimes(description, pair, { may_wait: true });
  require_that(pair.machine.overrun, "the firmware does not see that the machine waits");
}

/** The firmware starts the machine again in the state in which it is. */
function checkRestart(description, pair) {
  const { plan, commands } = description;
  const { machine, converter } = pair;
  converter.may_abort = !machine.levels.cs;
  machine.start(commands);
  step(pair);
  require_that(converter.frame === undefined && machine.levels.cs, "a start does not end the frame");
  const from = converter.frames.length;
  const count = commands.length + PIPELINE + 2 * plan.channels;
  checkFrames(description, pair, receive(pair, count, limit(plan, count)), { from });
}

/** The firmware stops and starts the machine while it waits, and at each step of a frame. */
function checkRestarts(description) {
  const waiting = started(description);
  stall(waiting, description);
  checkRestart(description, waiting);
  for (let steps = 0; ; steps++) {
    const pair = started(description);
    receive(pair, 4, limit(description.plan, 4));
    const begin = pair.machine.cycle;
    for (let k = 0; k < steps; k++) step(pair);
    if (pair.machine.cycle - begin >= frameCycles(description.plan)) return steps;
    checkRestart(description, pair);
  }
}

/** Everything; throws a fault. */
function check(description) {
  checkStall(description);
  checkSlowReader(description);
  const running = checkRunning(description);
  return { ...running, restarts: checkRestarts(description) };
}

/** The first fault of a program, if it has one. */
function faultOf(description) {
  try {
    check(description);
    return undefined;
  } catch (error) {
    if (error instanceof Fault) return error.message;
    throw error;
  }
}

const description = JSON.parse(fs.readFileSync(process.argv[2], "utf8"));
const emulator = JSON.parse(fs.readFileSync(path.join(__dirname, "package.json"), "utf8")).dependencies.rp2040js;
try {
  const { count, margin, restarts } = check(description);
  const wrong = mutants(description).map(({ name, ...changed }) => ({ name, fault: faultOf({ ...description, ...changed }) }));
  if (process.env.MASSLINE_VERBOSE) for (const { name, fault } of wrong) console.error(`${name}: ${fault}`);
  const unnoticed = wrong.filter(({ fault }) => fault === undefined);
  require_that(unnoticed.length === 0, `not noticed: ${unnoticed.map(({ name }) => name).join("; ")}`);
  const period = frameCycles(description.plan);
  const micros = (period * description.plan.divider * 1e6) / description.plan.core_hz;
  console.log(
    `PIO program in rp2040js ${emulator}: ${count} frames in order, each of ${period} cycles (${micros.toFixed(3)} µs); ` +
      `a bit is valid ${margin.toFixed(1)} ns before it is sampled; waits only with CS high; ${restarts} restarts within a frame; ` +
      `${wrong.length} wrong programs noticed`,
  );
} catch (error) {
  if (!(error instanceof Fault)) throw error;
  console.error(`PIO program in rp2040js ${emulator}: ${error.message}`);
  process.exitCode = 1;
}
