/* SPDX-License-Identifier: Apache-2.0
 * A cell without keys: what it does with key frames. */
#include "robotskin/commissioning.h"

#include "robotskin/crc.h"

enum { GROUP_CAME = 1, OWN_CAME = 2, BOTH_CAME = GROUP_CAME | OWN_CAME };

void rs_key_frame_of_key(uint8_t frame[RS_FRAME_BYTES], uint32_t step, const uint8_t key[RS_CELL_KEY_BYTES]) {
  const rs_key said = {.type = RS_TYPE_key,
                       .step = step,
                       .word_1 = rs_load32(key),
                       .word_2 = rs_load32(key + 4),
                       .word_3 = rs_load32(key + 8),
                       .word_4 = rs_load32(key + 12)};
  rs_key_pack(frame, &said);
  rs_frame_seal(frame);
}

void rs_key_frame_of_words(uint8_t frame[RS_FRAME_BYTES], uint32_t step, uint32_t first, uint32_t second) {
  const rs_key said = {.type = RS_TYPE_key, .step = step, .word_1 = first, .word_2 = second};
  rs_key_pack(frame, &said);
  rs_frame_seal(frame);
}

uint32_t rs_key_check(const uint8_t keys[RS_CELL_KEYS_BYTES], uint32_t uid, uint32_t step) {
  uint8_t covered[RS_CELL_KEY_BYTES + 5], tag[RS_CHASKEY_TAG_BYTES];
  for (unsigned i = 0; i < RS_CELL_KEY_BYTES; ++i) covered[i] = keys[i];
  rs_store32(covered + RS_CELL_KEY_BYTES, uid);
  covered[RS_CELL_KEY_BYTES + 4] = (uint8_t)step;
  rs_chaskey_key expanded;
  rs_chaskey_key_expand(&expanded, keys + RS_CELL_KEY_BYTES);
  rs_chaskey(&expanded, covered, sizeof covered, tag);
  return rs_load32(tag);
}

static void take_key(rs_commissioning* cell, unsigned came, const rs_key* said) {
  if (cell->kept) return;
  uint8_t* to = cell->keys + (came == OWN_CAME ? RS_CELL_KEY_BYTES : 0);
  rs_store32(to, said->word_1);
  rs_store32(to + 4, said->word_2);
  rs_store32(to + 8, said->word_3);
  rs_store32(to + 12, said->word_4);
  cell->come |= (uint8_t)came;
}

rs_commissioning_do rs_commissioning_frame(rs_commissioning* cell, uint32_t uid, const uint8_t frame[RS_FRAME_BYTES],
                                           uint8_t answer[RS_FRAME_BYTES]) {
  if (rs_frame_type_of(frame) != RS_TYPE_key) return RS_COMMISSIONING_NOTHING;
  rs_key said;
  rs_key_unpack(&said, frame);
  switch (said.step) {
    case RS_KEY_ask:
      if (cell->kept) break;
      rs_key_frame_of_words(answer, RS_KEY_factory, uid, RS_FIRMWARE_VERSION);
      return RS_COMMISSIONING_ANSWER;
    case RS_KEY_group:
      take_key(cell, GROUP_CAME, &said);
      return RS_COMMISSIONING_NOTHING;
    case RS_KEY_own:
      take_key(cell, OWN_CAME, &said);
      return RS_COMMISSIONING_NOTHING;
    case RS_KEY_keep: {
      if (said.word_1 != uid || cell->come != BOTH_CAME ||
          !rs_tags_equal(said.word_2, rs_key_check(cell->keys, uid, RS_KEY_keep)))
        break;
      rs_key_frame_of_words(answer, RS_KEY_kept, uid, rs_key_check(cell->keys, uid, RS_KEY_kept));
      const bool kept_before = cell->kept != 0U; /* the answer was lost */
      cell->kept = 1;
      return kept_before ? RS_COMMISSIONING_ANSWER : RS_COMMISSIONING_KEEP;
    }
    default:
      return RS_COMMISSIONING_NOTHING;
  }
  rs_key_frame_of_words(answer, RS_KEY_refused, uid, 0);
  return RS_COMMISSIONING_ANSWER;
}
