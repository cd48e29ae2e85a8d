// Compiles a function for several processor types; the loader chooses one at start, so one x86-64 build runs
// everywhere. The results of all versions are bit-identical, because multiplication and addition are never fused
// (-ffp-contract=off).
#pragma once

/// Use: TYPODONT_DISPATCH("avx2", "default") void kernel(…). Sanitizer builds have only the default version, because
/// the loader chooses before the sanitizer is initialised.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define TYPODONT_DISPATCH(...) __attribute__((target_clones(__VA_ARGS__)))
#else
#define TYPODONT_DISPATCH(...)
#endif
