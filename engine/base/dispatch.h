// Compiles functions for several processor types; the loader chooses the best version at load time. So one x86-64 build
// runs everywhere. All versions give the same bits, because multiply-adds are never contracted (-ffp-contract=off).
#pragma once

/// Usage, before a function: TYPODONT_DISPATCH("avx2", "default") void kernel(…). Sanitizer builds have only the
/// default version, because their runtimes are not initialised when the loader chooses.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define TYPODONT_DISPATCH(...) __attribute__((target_clones(__VA_ARGS__)))
#else
#define TYPODONT_DISPATCH(...)
#endif
