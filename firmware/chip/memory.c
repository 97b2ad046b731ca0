/* SPDX-License-Identifier: Apache-2.0
 * The functions that a compiler may call of its own accord where there is no C library. */
#include <stdint.h>
#include <string.h>

/* A loop that copies must not become a call of what it is part of. */
#if defined(__clang__)
#define PLAIN __attribute__((no_builtin))
#else
#define PLAIN __attribute__((optimize("no-tree-loop-distribute-patterns")))
#endif

PLAIN void* memcpy(void* restrict to, const void* restrict from, size_t count) {
  unsigned char* out = to;
  const unsigned char* in = from;
  if ((((uintptr_t)out | (uintptr_t)in) & 3U) == 0U) {
    uint32_t* words_out = to;
    const uint32_t* words_in = from;
    for (; count >= 16U; count -= 16U) {
      __asm__ volatile("ldmia %1!, {r3, r4, r5, r6}\n stmia %0!, {r3, r4, r5, r6}"
                       : "+l"(words_out), "+l"(words_in)
                       :
                       : "r3", "r4", "r5", "r6", "memory");
    }
    for (; count >= 4U; count -= 4U) *words_out++ = *words_in++;
    out = (unsigned char*)words_out;
    in = (const unsigned char*)words_in;
  }
  for (; count > 0U; --count) *out++ = *in++;
  return to;
}

PLAIN void* memmove(void* to, const void* from, size_t count) {
  unsigned char* out = to;
  const unsigned char* in = from;
  if (out <= in) return memcpy(to, from, count);
  while (count > 0U) {
    --count;
    out[count] = in[count];
  }
  return to;
}

PLAIN void* memset(void* to, int value, size_t count) {
  unsigned char* out = to;
  for (; count > 0U && ((uintptr_t)out & 3U) != 0U; --count) *out++ = (unsigned char)value;
  const uint32_t word = (unsigned char)value * 0x01010101U;
  for (; count >= 4U; count -= 4U, out += 4) *(uint32_t*)(void*)out = word;
  for (; count > 0U; --count) *out++ = (unsigned char)value;
  return to;
}

PLAIN int memcmp(const void* a, const void* b, size_t count) {
  const unsigned char *first = a, *second = b;
  for (; count > 0U; --count, ++first, ++second) {
    if (*first != *second) return *first < *second ? -1 : 1;
  }
  return 0;
}
