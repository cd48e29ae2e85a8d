# typodont_module(NAME SOURCES a.cpp … [PUBLIC lib …] [PRIVATE lib …]): adds a static library typodont_NAME. A shared
# library may contain its objects, as libtypodont.so does.
function(typodont_module name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(typodont_${name} STATIC ${ARG_SOURCES})
  target_link_libraries(typodont_${name} PUBLIC typodont_options ${ARG_PUBLIC} PRIVATE ${ARG_PRIVATE})
  set_target_properties(typodont_${name} PROPERTIES UNITY_BUILD ${TYPODONT_UNITY} POSITION_INDEPENDENT_CODE ON)
endfunction()

# typodont_pages(MODULE a.cpp …): adds files that show, read or write, and compute little. They are compiled with less
# optimisation, which takes two thirds of the time.
function(typodont_pages module)
  add_library(typodont_${module}_pages OBJECT ${ARGN})
  target_link_libraries(typodont_${module}_pages PRIVATE $<GENEX_EVAL:$<TARGET_PROPERTY:typodont_${module},LINK_LIBRARIES>>)
  target_compile_options(typodont_${module}_pages PRIVATE $<$<CONFIG:Release>:-O1>)
  set_target_properties(typodont_${module}_pages PROPERTIES UNITY_BUILD ${TYPODONT_UNITY} POSITION_INDEPENDENT_CODE ON)
  target_sources(typodont_${module} PRIVATE $<TARGET_OBJECTS:typodont_${module}_pages>)
endfunction()

# typodont_library(NAME HEADERS header …): makes the module NAME available to other programs as Typodont::NAME. Installs
# it, the headers, and all headers of this tree that they include. Headers are named relative to the module's folder.
function(typodont_library name)
  cmake_parse_arguments(ARG "" "" "HEADERS" ${ARGN})
  set(library typodont_${name})
  add_library(Typodont::${name} ALIAS ${library})
  set_target_properties(${library} PROPERTIES EXPORT_NAME ${name})
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

# Options of tests that measure no time. With -O1, GCC 12 warns wrongly about std::string.
set(typodont_test_options $<$<CONFIG:Release>:-O1>
    "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-stringop-overflow;-Wno-restrict>")

# typodont_test(NAME KIND unit|property|golden|stress|bench|acceptance SOURCES a.cpp … [LIBS lib …]): adds a GoogleTest
# program. Every test in it becomes a ctest named KIND.Suite.Claim with the label KIND (tests/support/add_tests.cmake).
# [LIVE] or [WINDOW]: the tests need real time, or a window on a display; they also get the label `live` and have a
# second try. One LIVE test runs at a time, and one test of each WINDOW program, because each of them starts its own
# display. [MEASURED regex]: these tests measure time and get the kind bench. [TOGETHER suite …]: the tests of such a
# suite share an expensive set-up, so they always run in one process. [ONE_PROCESS]: all tests of the program do, and
# become one ctest KIND.NAME. [LAUNCHER program …]: starts the test program. [ALONE]: no other test runs meanwhile.
function(typodont_test name)
  cmake_parse_arguments(ARG "LIVE;WINDOW;ONE_PROCESS;ALONE" "KIND;MEASURED" "SOURCES;LIBS;TOGETHER;LAUNCHER" ${ARGN})
  set(live)
  set(properties)
  if(ARG_KIND STREQUAL "bench" OR ARG_ALONE)
    set(properties RUN_SERIAL TRUE)
  elseif(ARG_LIVE)
    set(properties RESOURCE_LOCK live)
  elseif(ARG_WINDOW)
    set(properties RESOURCE_LOCK window_${name})
  endif()
  if(ARG_LIVE OR ARG_WINDOW)
    set(live TRUE)
    list(PREPEND ARG_LAUNCHER ${PROJECT_SOURCE_DIR}/tests/support/second_try.sh)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE typodont_options typodont_test_support ${ARG_LIBS} GTest::gtest GTest::gmock
                                        GTest::gtest_main)
  if(NOT ARG_KIND STREQUAL "bench")  # less optimisation and shared headers halve the time of compilation
    target_compile_options(${name} PRIVATE ${typodont_test_options})
    target_precompile_headers(${name} REUSE_FROM typodont_test_own_cache)
  endif()
  set(listed ${CMAKE_CURRENT_BINARY_DIR}/${name}_tests.txt)
  add_custom_command(TARGET ${name} POST_BUILD BYPRODUCTS ${listed} VERBATIM
                     COMMAND sh -c "\"$0\" --gtest_list_tests > \"$1\"" $<TARGET_FILE:${name}> ${listed}
                     WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  # Read by ctest.
  file(GENERATE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/${name}_tests.cmake CONTENT "
set(program \"$<TARGET_FILE:${name}>\")
set(listed \"${listed}\")
set(launcher \"${ARG_LAUNCHER}\")
set(kind ${ARG_KIND})
set(live \"${live}\")
set(measured \"${ARG_MEASURED}\")
set(together \"${ARG_TOGETHER}\")
set(one_process \"${ARG_ONE_PROCESS}\")
set(properties WORKING_DIRECTORY \"${PROJECT_SOURCE_DIR}\" ${properties})
include(\"${PROJECT_SOURCE_DIR}/tests/support/add_tests.cmake\")
")
  set_property(DIRECTORY APPEND PROPERTY TEST_INCLUDE_FILES ${CMAKE_CURRENT_BINARY_DIR}/${name}_tests.cmake)
endfunction()
