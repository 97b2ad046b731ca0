// SPDX-License-Identifier: Apache-2.0
// Compiles a kernel for several instruction sets; the machine it runs on picks one when the program is loaded.
#pragma once

// Sanitizers instrument the function that picks, which runs before they are ready.
#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && !defined(__SANITIZE_ADDRESS__)
#define ROBOTSKIN_INSTRUCTION_SETS __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
#else
#define ROBOTSKIN_INSTRUCTION_SETS
#endif
