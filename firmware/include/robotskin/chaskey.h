/* SPDX-License-Identifier: Apache-2.0
 * Chaskey-12 (ISO/IEC 29192-6): the message authentication code of ticks and commands.
 *
 * N. Mouha et al., "Chaskey: an efficient MAC algorithm for 32-bit microcontrollers", SAC 2014; 12 rounds as in its
 * revision of 2015. All words are little-endian, as published. */
#ifndef ROBOTSKIN_CHASKEY_H
#define ROBOTSKIN_CHASKEY_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { RS_CHASKEY_KEY_BYTES = 16, RS_CHASKEY_TAG_BYTES = 16, RS_CHASKEY_BLOCK_BYTES = 16 };

/* The key and its two subkeys. */
typedef struct {
  uint32_t word[12];
} rs_chaskey_key;

void rs_chaskey_key_expand(rs_chaskey_key* key, const uint8_t bytes[RS_CHASKEY_KEY_BYTES]);

/* Tag of a message of any length. */
void rs_chaskey(const rs_chaskey_key* key, const uint8_t* message, uint32_t count, uint8_t tag[RS_CHASKEY_TAG_BYTES]);

/* First 32 bits, big-endian, of the tag of one block: what a frame has room for. */
uint32_t rs_chaskey_tag32(const rs_chaskey_key* key, const uint8_t block[RS_CHASKEY_BLOCK_BYTES]);

/* Compares without a data-dependent branch, so that the time taken tells nothing about how much was right. */
bool rs_tags_equal(uint32_t a, uint32_t b);

#ifdef __cplusplus
}
#endif

#endif
