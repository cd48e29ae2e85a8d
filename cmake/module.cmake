# typodont_module(NAME SOURCES a.cpp … [PUBLIC lib …] [PRIVATE lib …] [PCH header …]): adds a static library
# typodont_NAME.
function(typodont_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE;PCH" ${ARGN})
  add_library(typodont_${name} STATIC ${ARG_SOURCES})
  target_link_libraries(typodont_${name} PUBLIC typodont_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  if(ARG_PCH)
    target_precompile_headers(typodont_${name} PRIVATE ${ARG_PCH})
  endif()
endfunction()

# typodont_library(NAME HEADERS header …): makes the module NAME available to other programs as Typodont::NAME. Installs
# it, the headers, and all headers of this tree that they include. Headers are named relative to the module's folder.
function(typodont_library name)
  cmake_parse_arguments(ARG "" "" "HEADERS" ${ARGN})
  set(library typodont_${name})
  add_library(Typodont::${name} ALIAS ${library})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  # Without this, functions that a shared library could replace are not inlined.
  target_compile_options(${library} PRIVATE -fno-semantic-interposition)
  set(headers)
  set(found ${ARG_HEADERS})
  list(TRANSFORM found PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/)
  while(found)
    list(POP_FRONT found header)
    if(header IN_LIST headers)
      continue()
    endif()
    list(APPEND headers ${header})
    file(STRINGS ${header} includes REGEX "^#include \"[a-z_]+/.*\"")
    list(TRANSFORM includes REPLACE "^#include \"([^\"]+)\".*" "${PROJECT_SOURCE_DIR}/\\1")
    list(APPEND found ${includes})
  endwhile()
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${headers})  # what they include may change
  target_sources(${library} PUBLIC FILE_SET HEADERS BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${headers})
  install(TARGETS ${library} EXPORT Typodont
          ARCHIVE COMPONENT development
          FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/typodont COMPONENT development)
  set_property(GLOBAL APPEND PROPERTY TYPODONT_INSTALLED ${name})
endfunction()

# typodont_test(NAME KIND unit|property|golden|stress|bench|acceptance SOURCES a.cpp … [LIBS lib …]): adds a GoogleTest
# program. Every test in it becomes a ctest named KIND.Suite.Claim with the label KIND. [LIVE] or [WINDOW]: the tests
# need real time, or a window on a display; they also get the label `live` and have a second try. One LIVE test runs at a
# time, and one test of each WINDOW program, because each of them starts its own display. [MEASURED pattern]: these tests
# measure time and get the kind bench. [TOGETHER suite …]: the tests of such a suite share an expensive set-up, so they
# run in one process and become one ctest named KIND.Suite.
include(GoogleTest)
function(typodont_test name)
  cmake_parse_arguments(ARG "LIVE;WINDOW" "KIND;MEASURED" "SOURCES;LIBS;TOGETHER" ${ARGN})
  set(alone)
  if(ARG_KIND STREQUAL "bench")
    set(alone RUN_SERIAL TRUE)
  elseif(ARG_LIVE)
    set(alone RESOURCE_LOCK live)
  elseif(ARG_WINDOW)
    set(alone RESOURCE_LOCK window_${name})
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE typodont_options typodont_test_support ${ARG_LIBS} GTest::gtest GTest::gmock
                                        GTest::gtest_main)
  if(ARG_LIVE OR ARG_WINDOW)  # gtest_discover_tests starts the program by its emulator, which may be set for this test already
    set_target_properties(${name} PROPERTIES CROSSCOMPILING_EMULATOR
                          "${PROJECT_SOURCE_DIR}/tests/support/second_try.sh;${CMAKE_CROSSCOMPILING_EMULATOR}")
  endif()
  set(elsewhere ${ARG_MEASURED})
  foreach(suite ${ARG_TOGETHER})
    list(APPEND elsewhere ${suite}.*)
    add_test(NAME ${ARG_KIND}.${suite} COMMAND ${name} --gtest_filter=${suite}.* WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${ARG_KIND}.${suite} PROPERTIES LABELS ${ARG_KIND} ${alone})
  endforeach()
  set(filter)
  if(elsewhere)
    list(JOIN elsewhere ":" elsewhere)
    set(filter TEST_FILTER -${elsewhere})
  endif()
  if(ARG_MEASURED)
    gtest_discover_tests(${name} TEST_PREFIX bench. TEST_FILTER ${ARG_MEASURED} TEST_LIST ${name}_measured
                         DISCOVERY_TIMEOUT 60 WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                         PROPERTIES LABELS bench RUN_SERIAL TRUE)
  endif()
  gtest_discover_tests(${name} TEST_PREFIX ${ARG_KIND}. ${filter} DISCOVERY_TIMEOUT 60
                       WORKING_DIRECTORY ${PROJECT_SOURCE_DIR}
                       PROPERTIES LABELS ${ARG_KIND} ${alone})
  if(ARG_LIVE OR ARG_WINDOW)  # gtest_discover_tests takes one label only
    set(more ${CMAKE_CURRENT_BINARY_DIR}/${name}_live.cmake)
    # These tests run one after the other, so they start first (ctest starts with the highest cost).
    file(WRITE ${more} "set_tests_properties(\${${name}_TESTS} PROPERTIES LABELS \"${ARG_KIND};live\" COST 1000)\n")
    set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${more})
  endif()
endfunction()
