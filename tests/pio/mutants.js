// Programs that are wrong on purpose: each must have a fault, or the check checks nothing.
"use strict";
const { decode, encode } = require("./machine.js");

const [JMP, IN, OUT, PUSH_OR_PULL, MOV, SET] = [0b000, 0b010, 0b011, 0b100, 0b101, 0b111];
const IS_PULL = 1 << 7;
const BLOCK = 1 << 5;
const SIDE_AND_DELAY = [8, 9, 10, 11, 12];
const DELAY = [8, 9, 10];

function mutants({ program, commands }) {
  const { words, wrap } = program;
  const instructions = words.map(decode);
  const find = (fits) => {
    const found = instructions.findIndex((instruction, k) => k >= wrap.target && fits(instruction));
    if (found < 0) throw new Error("the program has other instructions than its mutants need");
    return found;
  };
  const out = find(({ operation }) => operation === OUT);
  const input = find(({ operation }) => operation === IN);
  const jump = find(({ operation }) => operation === JMP);
  const pull = find(({ operation, operand }) => operation === PUSH_OR_PULL && operand & IS_PULL);
  const push = find(({ operation, operand }) => operation === PUSH_OR_PULL && !(operand & IS_PULL));
  const count = find(({ operation }) => operation === SET);
  const hold = find(({ operation, side }) => operation === MOV && side === 0b00);

  const of = (name, words, changed = wrap) => ({ name, program: { ...program, words, wrap: changed } });
  /** The program with other fields in some instructions. */
  const altered = (name, changes) =>
    of(name, instructions.map((instruction, k) => encode({ ...instruction, ...changes[k] })));
  const operand = (k, change) => ({ [k]: { operand: change(instructions[k].operand) } });
  /** The jump alone lasts as long as the clock is high. */
  const high_time = { delay: instructions[input].delay + instructions[jump].delay + 1 };
  /** The program without an instruction, which lies after the target of the jump. */
  const without = (k) => of(
    `without instruction ${k}`, words.filter((_, other) => other !== k), { ...wrap, source: wrap.source - 1 },
  );

  const single_bits = words.flatMap((word, k) =>
    SIDE_AND_DELAY
      // A longer delay before the first frame does no harm.
      .filter((bit) => k >= wrap.target || !DELAY.includes(bit))
      .map((bit) => of(`bit ${bit} of word ${k}`, words.map((other, at) => (at === k ? word ^ (1 << bit) : other)))),
  );
  return [
    ...single_bits,
    { ...without(hold), name: "CS rises with the sixteenth falling edge" },
    // Clock and CS are as they should be in these two.
    altered("sampled at the falling edge", {
      [out]: { ...instructions[input], side: 0b00, delay: 0 },
      [input]: { ...instructions[out], delay: instructions[out].delay - 1 },
      [jump]: high_time,
    }),
    altered("sampled before the bit is valid", {
      [out]: { delay: 0 },
      [input]: { side: 0b00, delay: instructions[out].delay - 1 },
      [jump]: high_time,
    }),
    altered("push with CS low", { [push]: { side: 0b00 } }),
    altered("push that does not wait", operand(push, (bits) => bits & ~BLOCK)),
    altered("pull that waits", operand(pull, (bits) => bits | BLOCK)),
    altered("a clock too few", operand(count, (bits) => bits - 1)),
    altered("a clock too many", operand(count, (bits) => bits + 1)),
    altered("two bits in", operand(input, (bits) => bits + 1)),
    altered("two bits out", operand(out, (bits) => bits + 1)),
    altered("the loop begins at `in`", operand(jump, (bits) => bits + 1)),
    of("the first word in each frame", words, { ...wrap, target: 0 }),
    of("no push", words, { ...wrap, source: wrap.source - 1 }),
    { name: "commands in the wrong order", commands: [...commands].reverse() },
    { name: "the last channel is not programmed", commands: [0, ...commands.slice(1)] },
  ];
}

module.exports = { mutants };
