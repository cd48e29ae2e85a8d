# Checks that every file is formatted. It takes seconds and runs before all other tests (ctest starts with the highest
# cost).
add_test(NAME guard.Format.EveryFileIsAsClangFormatWritesIt COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/guard/format.sh)
set_tests_properties(guard.Format.EveryFileIsAsClangFormatWritesIt PROPERTIES LABELS guard COST 1000000000)
if(TYPODONT_UNITY)
  add_test(NAME guard.Unity.AnonymousNamesAreUniqueInATarget
           COMMAND ${CMAKE_CURRENT_SOURCE_DIR}/guard/unity_names.py ${CMAKE_BINARY_DIR})
  set_tests_properties(guard.Unity.AnonymousNamesAreUniqueInATarget PROPERTIES LABELS guard)
endif()
# Counts the instructions of the hot paths with callgrind. Only for release builds, which users run.
if(CMAKE_BUILD_TYPE STREQUAL "Release" AND NOT TYPODONT_SANITIZE)
  add_executable(hot_paths guard/hot_paths.cpp)
  target_link_libraries(hot_paths PRIVATE typodont_app)
  typodont_test(guard KIND guard SOURCES guard/guard_test.cpp)
  target_compile_definitions(guard PRIVATE TYPODONT_HOT_PATHS="$<TARGET_FILE:hot_paths>")
  target_link_libraries(guard PRIVATE fmt::fmt)
  add_dependencies(guard hot_paths)
endif()
