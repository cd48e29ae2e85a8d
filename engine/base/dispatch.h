// Compiles a function once for each of several processor types. When the program starts, the loader chooses the best
// version for the processor, so that one x86-64 build runs on every machine. All versions compute the same bits,
// because the compiler never joins a multiplication and an addition into one instruction (-ffp-contract=off).
#pragma once

/// Write this macro before a function: TYPODONT_DISPATCH("avx2", "default") void kernel(…). Sanitizer builds have only
/// the default version, because the loader chooses a version before the sanitizer is initialised.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define TYPODONT_DISPATCH(...) __attribute__((target_clones(__VA_ARGS__)))
#else
#define TYPODONT_DISPATCH(...)
#endif
