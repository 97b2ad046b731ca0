/* SPDX-License-Identifier: Apache-2.0
 * The image in which a cell keeps its torque parameters. */
#include "robotskin/crc.h"
#include "robotskin/torque_parameters.h"

enum { IMAGE_VERSION = 1, JOINTS_AT = 2 };
RS_STATIC_ASSERT(RS_TORQUE_CHECKSUM_AT + 2 <= RS_TORQUE_IMAGE_BYTES, "the checksum is part of the image");

static uint8_t* put16(uint8_t* at, int32_t value) {
  at[0] = (uint8_t)((uint32_t)value >> 8);
  at[1] = (uint8_t)value;
  return at + 2;
}

static uint8_t* put16s(uint8_t* at, const int16_t* values, unsigned count) {
  for (unsigned i = 0; i < count; ++i) at = put16(at, values[i]);
  return at;
}

static const uint8_t* get16(const uint8_t* at, uint16_t* value) {
  *value = (uint16_t)(((uint32_t)at[0] << 8) | at[1]);
  return at + 2;
}

static const uint8_t* get16s(const uint8_t* at, int16_t* values, unsigned count) {
  for (unsigned i = 0; i < count; ++i) {
    uint16_t bits;
    at = get16(at, &bits);
    values[i] = (int16_t)((int32_t)(bits ^ 0x8000U) - 0x8000);
  }
  return at;
}

static uint8_t* put_sense(uint8_t* at, const rs_sense* sense) {
  at = put16(at, sense->silent);
  at = put16(at, sense->full);
  return put16(at, sense->weight);
}

static const uint8_t* get_sense(const uint8_t* at, rs_sense* sense) {
  at = get16(at, &sense->silent);
  at = get16(at, &sense->full);
  return get16(at, &sense->weight);
}

/* A sliding joint's way in the chain's units, rounded up. */
static int32_t slide_units(const rs_torque_parameters* parameters) {
  const int exponent = parameters->chain.length_exponent;
  if (exponent >= 0) return (parameters->slide >> exponent) + 1;
  return (int32_t)((uint32_t)parameters->slide << -exponent);
}

uint32_t rs_torque_parameters_bytes(const uint8_t image[RS_TORQUE_IMAGE_BYTES]) {
  const uint32_t joints = image[JOINTS_AT];
  const uint32_t places = joints == 0U ? 0U : joints > RS_CHAIN_JOINTS ? RS_CHAIN_JOINTS - 1U : joints - 1U;
  return RS_TORQUE_PLACES_AT + places * RS_TORQUE_PLACE_BYTES;
}

uint16_t rs_torque_parameters_checksum(const uint8_t image[RS_TORQUE_IMAGE_BYTES]) {
  return rs_crc16(image, rs_torque_parameters_bytes(image));
}

void rs_torque_parameters_pack(const rs_torque_parameters* parameters, uint8_t image[RS_TORQUE_IMAGE_BYTES]) {
  const rs_chain* chain = &parameters->chain;
  for (unsigned i = 0; i < RS_TORQUE_IMAGE_BYTES; ++i) image[i] = 0;
  uint8_t* at = image;
  *at++ = IMAGE_VERSION;
  *at++ = parameters->limb;
  *at++ = chain->joints;
  *at++ = (uint8_t)chain->length_exponent;
  *at++ = parameters->step_bits;
  *at++ = 0;
  at = put16(at, chain->prismatic);
  at = put16(at, parameters->slide);
  at = put16s(at, chain->point, 3);
  at = put16s(at, chain->direction, 3);
  at = put_sense(at, &parameters->gains.force);
  *at++ = parameters->gains.force.weight_bits;
  *at++ = parameters->gains.proximity.weight_bits;
  at = put_sense(at, &parameters->gains.proximity);
  for (unsigned l = 0; l + 1U < chain->joints && l + 1U < RS_CHAIN_JOINTS; ++l) {
    at = put16s(at, chain->place[l].rotation, 9);
    at = put16s(at, chain->place[l].offset, 3);
  }
  put16(image + RS_TORQUE_CHECKSUM_AT, rs_torque_parameters_checksum(image));
}

bool rs_torque_parameters_unpack(rs_torque_parameters* parameters, const uint8_t image[RS_TORQUE_IMAGE_BYTES]) {
  *parameters = (rs_torque_parameters){.limb = 0};
  uint16_t checksum;
  get16(image + RS_TORQUE_CHECKSUM_AT, &checksum);
  if (image[0] != IMAGE_VERSION || checksum != rs_torque_parameters_checksum(image)) return false;
  rs_chain* chain = &parameters->chain;
  const uint8_t* at = image + 1;
  parameters->limb = *at++;
  chain->joints = *at++;
  chain->length_exponent = (int8_t)((int32_t)(*at++ ^ 0x80U) - 0x80);
  parameters->step_bits = *at++;
  ++at;
  at = get16(at, &chain->prismatic);
  at = get16(at, &parameters->slide);
  at = get16s(at, chain->point, 3);
  at = get16s(at, chain->direction, 3);
  at = get_sense(at, &parameters->gains.force);
  parameters->gains.force.weight_bits = *at++;
  parameters->gains.proximity.weight_bits = *at++;
  at = get_sense(at, &parameters->gains.proximity);
  for (unsigned l = 0; l + 1U < chain->joints && l + 1U < RS_CHAIN_JOINTS; ++l) {
    at = get16s(at, chain->place[l].rotation, 9);
    at = get16s(at, chain->place[l].offset, 3);
  }
  if (parameters->limb < RS_TORQUE_LIMBS && parameters->step_bits < RS_TORQUE_BITS && parameters->slide <= INT16_MAX &&
      rs_chain_valid(chain, slide_units(parameters))) {
    return true;
  }
  chain->joints = 0;
  return false;
}
