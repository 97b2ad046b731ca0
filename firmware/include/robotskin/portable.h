/* SPDX-License-Identifier: Apache-2.0
 * What C11 and C++20 spell differently, so that one header serves cell, driver and simulator. */
#ifndef ROBOTSKIN_PORTABLE_H
#define ROBOTSKIN_PORTABLE_H

#ifdef __cplusplus
#define RS_STATIC_ASSERT(condition, message) static_assert(condition, message)
#else
#define RS_STATIC_ASSERT(condition, message) _Static_assert(condition, message)
#endif

/* RS_AT_WORD: of an address where a frame begins. A processor that loads whole words from whole words alone is built
 * with RS_FRAMES_AT_WORDS, and then all frames begin at one; others take them as they come.
 * RS_NOINLINE: a function that is never merged with its caller, which then has the few registers of a small processor
 * for itself. RS_HOT: a function that runs so often that a chip holds it in RAM, where no fetch waits; built with
 * RS_HOT_IN_RAM. RS_WORDS: begins at a whole word, so that it can be copied a word at a time. RS_ALIAS: of a type
 * through which objects of other types are read. */
#if defined(__GNUC__)
#define RS_INLINE static inline __attribute__((always_inline, unused))
#define RS_NOINLINE __attribute__((noinline))
#define RS_WORDS __attribute__((aligned(4)))
#define RS_ALIAS __attribute__((may_alias))
#else
#define RS_INLINE static inline
#define RS_NOINLINE
#define RS_WORDS
#define RS_ALIAS
#endif
#if defined(RS_HOT_IN_RAM) && defined(__GNUC__)
#define RS_HOT __attribute__((noinline, section(".hot")))
#else
#define RS_HOT
#endif
#if defined(RS_FRAMES_AT_WORDS) && defined(__GNUC__)
#define RS_AT_WORD(address) __builtin_assume_aligned((address), 4)
#else
#define RS_AT_WORD(address) (address)
#endif

#endif
