// Functions compiled for several processors, the best chosen at load time: a plain x86-64 build runs everywhere, and
// because no multiply-adds are contracted (-ffp-contract=off) all versions give the same bits.
#pragma once

/// Before a function: TYPODONT_DISPATCH("avx2", "default") void kernel(…). The sanitizers' builds have only the
/// default: their runtimes are not ready yet when the loader chooses.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define TYPODONT_DISPATCH(...) __attribute__((target_clones(__VA_ARGS__)))
#else
#define TYPODONT_DISPATCH(...)
#endif
