/* What C11 and C++20 spell differently, so that one header serves cell, driver and simulator. */
#ifndef ROBOTSKIN_PORTABLE_H
#define ROBOTSKIN_PORTABLE_H

#ifdef __cplusplus
#define RS_STATIC_ASSERT(condition, message) static_assert(condition, message)
#else
#define RS_STATIC_ASSERT(condition, message) _Static_assert(condition, message)
#endif

#if defined(__GNUC__)
#define RS_INLINE static inline __attribute__((always_inline, unused))
#else
#define RS_INLINE static inline
#endif

#endif
