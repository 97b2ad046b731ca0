// SPDX-License-Identifier: Apache-2.0
// Two Picos, port 2 of one wired to port 3 of the other, pin to pin: node two.mjs A.uf2 B.uf2 MILLISECONDS. Out: one JSON
// object of [port, hex] of every frame of each, and the framing errors.
import { Chip, HEARS_AT } from './chip.mjs';

const [, , fileA, fileB, milliseconds] = process.argv;
const a = new Chip(fileA, 5), b = new Chip(fileB, 777);
const LAG = 32; // cycles that an edge takes
const cable = (from, out, to, into) => {
  from.wire = (port, level) => {
    if (port !== out) return;
    const at = Math.max(from.now, to.now) + LAG;
    to.at(at, () => to.setPin(HEARS_AT + into, !!level));
  };
};
cable(a, 1, b, 2);
cable(b, 2, a, 1);
for (let at = 0; at < milliseconds * 128000; at += 16) {
  a.run(at);
  b.run(at);
}
const told = (chip) => ({
  frames: chip.frames.map(([port, , bytes]) => [port + 1, Buffer.from(bytes).toString('hex')]),
  framing_errors: chip.framingErrors,
  said: [...new Set(chip.said)],
});
process.stdout.write(JSON.stringify([told(a), told(b)]) + '\n');
process.exit(0);
