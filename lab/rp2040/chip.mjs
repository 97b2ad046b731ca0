// SPDX-License-Identifier: Apache-2.0
// A Raspberry Pi Pico in the emulator rp2040js, mended where the cell's firmware needs what it lacks: the time of PIO,
// the sleep of the processor, the boot ROM, the round of the analogue inputs. Its sensors are tables of registers.
import { RP2040 } from 'rp2040js';
import { readFileSync } from 'node:fs';
export const PORTS = 4, SENDS_AT = 2, HEARS_AT = 6, FORGET_AT = 22, FRAME = 20, BIT_NS = 250;
const HZ = 128e6, CYCLE_NS = 1e9 / HZ;

function crc32(data) {
  let c = 0xffffffff;
  for (const b of data) {
    c ^= b << 24;
    for (let i = 0; i < 8; ++i) c = c & 0x80000000 ? (c << 1) ^ 0x04c11db7 : c << 1;
  }
  return c >>> 0;
}
/** Addresses in the ROM that stands for the mask ROM: functions are a BKPT each. */
const ROM_LOOKUP = 0x100, ROM_FUNCTIONS = 0x110;
const CODES = ['IF', 'EX', 'RE', 'RP', 'FC', 'CX'];

export class Chip {
  /** `kept`: the flash of an earlier life, in place of the file; `forget`: the pin for it is at ground. */
  constructor(uf2, random, { kept, forget } = {}) {
    const mcu = (this.mcu = new RP2040());
    mcu.logger = { debug() {}, info() {}, warn: (n, m) => this.said.push(`${n}: ${m}`), error: (n, m) => this.said.push(`${n}: ${m}`) };
    this.said = [];
    this.record = [];
    if (kept) mcu.flash.set(readFileSync(kept));
    this.forget = !!forget;
    const data = kept ? Buffer.alloc(0) : readFileSync(uf2);
    for (let at = 0; at < data.length; at += 512) {
      if (data.readUInt32LE(at) !== 0x0a324655 || data.readUInt32LE(at + 28) !== 0xe48bff56) throw new Error('no UF2 of this family');
      mcu.flash.set(data.subarray(at + 32, at + 32 + 256), data.readUInt32LE(at + 12) - 0x10000000);
    }
    mcu.peripherals[0x4006c] = { writeUint32Atomic: (offset, value) => this.note(value >>> 0), readUint32: () => 1 };
    let drawn = random >>> 0; // the ring oscillator's bits
    mcu.peripherals[0x40060] = {
      writeUint32Atomic() {},
      readUint32: () => ((drawn = (Math.imul(drawn, 1664525) + 1013904223) >>> 0) >>> 31),
    };
    this.startSensors();
    mcu.onBreak = (code) => this.romCall(code);
    // PIO: rp2040js runs it by setTimeout, an instruction a step; here each machine has its own time in clk_sys cycles.
    for (const pio of mcu.pio) {
      pio.run = () => {};
      pio.sm = pio.machines.map((machine) => ({ machine, next: 0, asleep: false }));
    }
    this.sms = mcu.pio.flatMap((pio) => pio.sm.map((sm) => ({ ...sm, pio })));
    // `gpioValues` would walk all pins at each bit.
    this.pins = 0;
    Object.defineProperty(mcu, 'gpioValues', { get: () => this.pins });
    this.now = 0; // cycles
    this.events = []; // [cycle, fn] sorted heap (small)
    this.decode = Array.from({ length: PORTS }, () => ({ level: 1, busy: false, byte: 0, bits: 0 }));
    this.out = Array.from({ length: PORTS }, () => []);
    this.frames = [];
    this.framingErrors = 0;
    this.restarts = 0;
    mcu.peripherals[0x40058].onWatchdogTrigger = () => ++this.restarts;
    this.instructions = 0;
    this.busyCycles = 0;
    this.lineFree = Array(PORTS).fill(0);
    // WFI as a Cortex-M0+ does it: rp2040js sleeps on what is pending already, and enters the handler despite PRIMASK.
    const core = mcu.core;
    core.setInterrupt = (irq, value) => {
      if (!value) { core.pendingInterrupts &= ~(1 << irq); return; }
      core.pendingInterrupts |= 1 << irq;
      core.interruptsUpdated = true;
      if (core.waiting && core.enabledInterrupts & (1 << irq)) core.waiting = false;
    };
    this.powerUp();
  }
  powerUp() {
    const { mcu } = this;
    const rom = new Uint8Array(16384), v = new DataView(rom.buffer);
    v.setUint16(0x14, 0x200, true);
    v.setUint16(0x18, ROM_LOOKUP | 1, true);
    v.setUint16(ROM_LOOKUP, 0xbe80, true);
    v.setUint16(ROM_LOOKUP + 2, 0x4770, true);
    CODES.forEach((_, i) => {
      v.setUint16(ROM_FUNCTIONS + 4 * i, 0xbe00 | (0x81 + i), true);
      v.setUint16(ROM_FUNCTIONS + 4 * i + 2, 0x4770, true);
    });
    mcu.bootrom.set(new Uint32Array(rom.buffer));
    const boot2 = mcu.flash.slice(0, 256);
    if (crc32(boot2.subarray(0, 252)) !== new DataView(boot2.buffer).getUint32(252, true)) throw new Error('boot2: wrong CRC, the chip would show its USB disk');
    mcu.sram.set(boot2, 0x41f00);
    mcu.core.SP = 0x20041f00;
    mcu.core.LR = 0;
    mcu.core.PC = 0x20041f00;
    for (let p = 0; p < PORTS; ++p) this.setPin(HEARS_AT + p, true);
    this.setPin(FORGET_AT, !this.forget); // rp2040js knows no pull-ups
  }
  romCall(code) {
    const { mcu } = this, { core } = mcu, r = core.registers;
    if (code === 0x80) {
      const i = CODES.indexOf(String.fromCharCode(r[1] & 255, (r[1] >> 8) & 255));
      if (i < 0) throw new Error('ROM function unknown');
      r[0] = (ROM_FUNCTIONS + 4 * i) | 1;
    } else if (CODES[code - 0x81] === 'RE') mcu.flash.fill(0xff, r[0], r[0] + r[1]), (this.erased = (this.erased ?? 0) + 1);
    else if (CODES[code - 0x81] === 'RP') for (let i = 0; i < r[2]; ++i) mcu.flash[r[0] + i] &= mcu.readUint8(r[1] + i);
    else if (code < 0x80) throw new Error(`fault at 0x${core.PC.toString(16)} (bkpt ${code})`);
  }
  setPin(pin, high) {
    this.pins = high ? this.pins | (1 << pin) : this.pins & ~(1 << pin);
    this.mcu.gpio[pin].setInputValue(high);
  }
  at(cycle, fn) {
    let i = this.events.length;
    while (i > 0 && this.events[i - 1][0] < cycle) --i;  // last is the earliest
    while (i > 0 && this.events[i - 1][0] === cycle) --i;
    this.events.splice(i, 0, [cycle, fn]);
  }
  get nowUs() { return (this.now * CYCLE_NS) / 1000; }
  /** Bytes on the chip's receiving line of a port, from now on; `percent` faster or slower than 4 Mb/s. */
  send(port, bytes, percent = 0) {
    const bit = (BIT_NS / CYCLE_NS) / (1 + percent / 100);
    let t = Math.max(this.now, this.lineFree[port]);
    const pin = HEARS_AT + port;
    for (const byte of bytes) {
      let level = 1;
      const frame = (byte << 1) | 0x200;
      for (let i = 0; i < 10; ++i) {
        const want = (frame >> i) & 1;
        if (want !== level) { level = want; const high = !!want; this.at(Math.round(t + i * bit), () => this.setPin(pin, high)); }
      }
      t += 10 * bit;
    }
    this.lineFree[port] = t;
    return t;
  }
  edge(port, level) {
    const d = this.decode[port];
    d.level = level;
    if (this.wire) this.wire(port, level);
    if (!d.busy && !level) {
      d.busy = true; d.byte = 0; d.bits = 0; d.startedAt = this.now;
      this.at(this.now + 48, () => this.sampleBit(port));
    }
  }
  sampleBit(port) {
    const d = this.decode[port];
    if (d.bits < 8) {
      d.byte |= d.level << d.bits;
      ++d.bits;
      this.at(this.now + 32, () => this.sampleBit(port));
      return;
    }
    d.busy = false;
    if (!d.level) ++this.framingErrors;
    this.out[port].push(d.byte);
    if (!d.frameAt) d.frameAt = d.startedAt;
    if (this.out[port].length === FRAME) {
      this.frames.push([port, this.nowUs, this.out[port], (d.frameAt * CYCLE_NS) / 1000]);
      this.out[port] = []; d.frameAt = 0;
      this.stop = true;
    }
  }
  // I2C at 400 kHz takes 22.5 us a byte; a part is a table of registers by its address on the bus.
  startSensors() {
    const { mcu } = this, bus = mcu.i2c[0], BYTE = 22.5 * 128, parts = (this.parts = new Map());
    let part, pointer = 0, first = true;
    // rp2040js 1.4.1 does not take the mask of its interrupts.
    const write = bus.writeUint32.bind(bus);
    bus.writeUint32 = (offset, value) => {
      if (offset !== 0x30) return write(offset, value);
      bus.intEnable = value;
      bus.checkInterrupts();
    };
    bus.onStart = () => this.at(this.now + 320, () => bus.completeStart());
    bus.onConnect = (address) => {
      part = parts.get(address);
      first = true;
      this.at(this.now + BYTE, () => bus.completeConnect(!!part));
    };
    bus.onWriteByte = (value) => {
      if (first) pointer = value;
      else part.set(pointer++, value);
      first = false;
      this.at(this.now + BYTE, () => bus.completeWrite(true));
    };
    const read = (at) => part.get(at) ?? part.get(at & 0x7f) ?? 0; // a high bit may ask for the registers that follow
    bus.onReadByte = () => this.at(this.now + BYTE, () => bus.completeRead(read(pointer++)));
    bus.onStop = () => this.at(this.now + 320, () => bus.completeStop());
    // rp2040js 1.4.1 masks the next input of a round by the wrong number, and leaves the first one out.
    Object.defineProperty(mcu.adc, 'activeChannel', {
      get() { return (this.cs >> 12) & 7; },
      set() {
        let next = ((this.cs >> 12) & 7) + 1;
        while (!((this.cs >> 16) & (1 << next % 5))) ++next;
        this.cs = (this.cs & ~(7 << 12)) | ((next % 5) << 12);
      },
    });
  }
  note(word) {
    this.record.push(word);
    if (this.onRecord) this.onRecord(word);
  }
  /** Runs to a cycle, or to the end of a frame that comes out if `early`. */
  run(until, early = false) {
    const { mcu } = this, { core, clock } = mcu;
    this.stop = false;
    while (this.now < until && !(early && this.stop)) {
      // What is next: events of the lines, machines, the core, the clock's alarms.
      let next = until;
      if (!core.waiting) next = this.now;
      else {
        for (const sm of this.sms) if (sm.machine.enabled && !sm.machine.waiting && sm.next < next) next = sm.next;
        const ev = this.events[this.events.length - 1];
        if (ev && ev[0] < next) next = ev[0];
        if (clock.nextAlarm) { const a = Math.ceil(clock.nextAlarm.nanos / CYCLE_NS); if (a < next) next = a; }
        if (next < this.now) next = this.now;
      }
      if (core.waiting) this.now = next;
      else {
        const c = core.executeInstruction();
        ++this.instructions;
        this.busyCycles += c;
        this.now += c || 1;
        if (core.waiting && core.pendingInterrupts & core.enabledInterrupts) core.waiting = false;
      }
      this.settle();
    }
  }
  settle() {
    const { mcu } = this, { clock } = mcu, { events } = this;
    while (events.length && events[events.length - 1][0] <= this.now) {
      const [t, fn] = events.pop();
      const save = this.now; this.machinesTo(t); this.now = t; fn(); this.now = save;
    }
    this.machinesTo(this.now);
    const nanos = this.now * CYCLE_NS;
    if (nanos >= clock.nanosCounter) clock.tick(nanos - clock.nanosCounter);
  }
  machinesTo(now) {
    for (const sm of this.sms) {
      const { machine } = sm;
      if (!machine.enabled) { sm.next = now; continue; }
      if (sm.asleep) {
        if (machine.waiting) { continue; }
        sm.asleep = false;
        sm.next = now + machine.clockDivInt;   // woken by what happened now
      }
      while (sm.next <= now) {
        const before = machine.cycles;
        machine.step();
        sm.next += (machine.cycles - before) * machine.clockDivInt;
        if (machine.waiting) { sm.asleep = true; break; }
      }
      const { pio } = sm;
      if (pio.pinValues !== pio.oldPinValues) {
        const changed = pio.pinValues ^ pio.oldPinValues;
        pio.checkChangedPins();
        for (let p = 0; p < PORTS; ++p) if (changed & (1 << (SENDS_AT + p))) {
          const save = this.now; this.now = now; this.edge(p, (pio.pinValues >> (SENDS_AT + p)) & 1); this.now = save;
        }
      }
    }
  }
}
