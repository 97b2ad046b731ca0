// SPDX-License-Identifier: Apache-2.0
// One JSON line in, one out: {until_us, send: [[port, hex, percent]], parts: {address: {register: value}}, adc: [...]}
// -> {now_us, frames: [[port, us, hex, from_us]], ...}. It answers early when a frame has come out.
import { Chip } from './chip.mjs';
import { createInterface } from 'node:readline';
import { writeFileSync } from 'node:fs';

const boot = JSON.parse(process.argv[2]);
const chip = new Chip(boot.uf2, boot.random, boot);
const log = []; // what the board was asked and answered
// Words of each kind of record (rp2040_board.c).
const WORDS = { 1: 2, 2: 2, 3: 5, 4: 2, 5: 3, 6: 3, 7: 2, 8: 2, 9: 2, 10: 1, 11: 11, 12: 3, 13: 2 };
if (boot.record) {
  let words = [];
  const ram = (at, count) => Buffer.from(chip.mcu.sram.slice(at - 0x20000000, at - 0x20000000 + count)).toString('hex');
  chip.onRecord = (word) => {
    words.push(word);
    if (words.length < WORDS[words[0]]) return;
    const kind = words[0];
    if (kind === 5) log.push(`5 ${words[1] & 255} ${words[1] >> 8} ${ram(words[2], words[1] & 255) || '-'}`);
    else if (kind === 6) log.push(`6 ${words[1]} ${ram(words[2], 20)}`);
    else if (kind === 9) log.push(`9 ${ram(words[1], boot.flash_bytes)}`);
    else if (kind === 11) log.push(words.map((one, at) => (at && at < 10 ? one | 0 : one)).join(' '));
    else log.push(words.join(' '));
    words = [];
  };
}
for await (const line of createInterface({ input: process.stdin })) {
  const ask = JSON.parse(line);
  if (ask.end) break;
  for (const [address, registers] of Object.entries(ask.parts ?? {})) {
    const part = chip.parts.get(+address) ?? new Map();
    chip.parts.set(+address, part);
    for (const [register, value] of Object.entries(registers)) part.set(+register, value);
  }
  for (const address of ask.unplug ?? []) chip.parts.delete(address);
  if (ask.save) writeFileSync(ask.save, chip.mcu.flash);
  if (ask.adc) chip.mcu.adc.channelValues = ask.adc;
  for (const [port, hex, percent] of ask.send ?? []) chip.send(port, Buffer.from(hex, 'hex'), percent ?? 0);
  if (ask.until_us !== undefined) chip.run(Math.ceil(ask.until_us * 128 - 1e-6), true);
  const frames = chip.frames.map(([port, us, bytes, from]) => [port, us, Buffer.from(bytes).toString('hex'), from]);
  chip.frames = [];
  process.stdout.write(
    JSON.stringify({
      now_us: chip.nowUs,
      frames,
      busy_cycles: chip.busyCycles,
      framing_errors: chip.framingErrors,
      restarts: chip.restarts,
      said: [...new Set(chip.said)],
      parts: ask.show && [...(chip.parts.get(ask.show) ?? new Map())],
    }) + '\n',
  );
}
if (boot.record) writeFileSync(boot.record, log.join('\n') + '\n');
process.exit(0);
