// SPDX-License-Identifier: Apache-2.0
// Three vibrators of feeling feet behind a microcontroller: `robotskin app feet --serial /dev/ttyUSB0`.
// Takes lines `V front centre back`, each 0 to 255, at 115200 baud. Any other line moves nothing.

const int PIN[3] = {9, 10, 11};  // with pulse width; each drives the gate of a transistor, never a motor itself
const unsigned long SILENT_MS = 90;  // without a whole line for so long the motors stop: within 100 ms
char line[24];
unsigned int length = 0;
unsigned long heard_ms = 0;

void drive(int front, int centre, int back) {
  analogWrite(PIN[0], front);
  analogWrite(PIN[1], centre);
  analogWrite(PIN[2], back);
}

void take_line() {
  int duty[3];
  char rest;
  if (sscanf(line, "V %d %d %d%c", &duty[0], &duty[1], &duty[2], &rest) != 3) return;
  for (int value : duty)
    if (value < 0 || value > 255) return;
  drive(duty[0], duty[1], duty[2]);
  heard_ms = millis();
}

void setup() {
  for (int pin : PIN) pinMode(pin, OUTPUT);
  drive(0, 0, 0);
  Serial.begin(115200);
}

void loop() {
  while (Serial.available() > 0) {
    const char byte = Serial.read();
    if (byte == '\n') {
      line[length < sizeof line ? length : 0] = '\0';  // a line that is too long is none
      take_line();
      length = 0;
    } else {
      if (length < sizeof line) line[length++] = byte;
    }
  }
  if (millis() - heard_ms > SILENT_MS) drive(0, 0, 0);
}
