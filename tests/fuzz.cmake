# Fuzzing of every parser of external data: with coverage feedback in the preset fuzz (./run fuzz), and with the stored
# corpus in all presets.
add_library(typodont_fuzz_targets STATIC fuzz/targets.cpp)
target_link_libraries(typodont_fuzz_targets PUBLIC typodont_app typodont_device_emulation typodont_import)
typodont_test(stress_fuzz KIND stress SOURCES stress/fuzz_corpus_test.cpp LIBS typodont_fuzz_targets)
if(TYPODONT_SANITIZE MATCHES "fuzzer")
  add_executable(fuzz fuzz/fuzzer.cpp)
  target_link_libraries(fuzz PRIVATE typodont_fuzz_targets TBB::tbb -fsanitize=fuzzer)
endif()
