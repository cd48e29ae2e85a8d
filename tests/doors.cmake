# Tests of the language bindings (engine/bindings).
typodont_test(unit_handles KIND unit SOURCES unit/handles_test.cpp LIBS typodont_bindings)
if(TYPODONT_SANITIZE)  # the same hosts as below, with the C interface linked into them
  foreach(host two_threads hostile random_host)
    add_executable(doors_${host} acceptance/doors/${host}.c)
    set_target_properties(doors_${host} PROPERTIES LINKER_LANGUAGE CXX)
    target_link_libraries(doors_${host} PRIVATE typodont_bindings)
  endforeach()
  add_test(NAME stress.Doors.AServoOnAThreadOfItsOwnUnderSanitizers
           COMMAND doors_two_threads ${CMAKE_CURRENT_SOURCE_DIR}/acceptance/doors/ball.json two_threads.h5)
  add_test(NAME stress.Doors.AHostileHostUnderSanitizers COMMAND doors_hostile)
  foreach(seed RANGE 1 3)
    add_test(NAME stress.Doors.RandomCallsOnThreeThreadsUnderSanitizers.${seed} COMMAND doors_random_host ${seed} 20000)
    set_tests_properties(stress.Doors.RandomCallsOnThreeThreadsUnderSanitizers.${seed} PROPERTIES LABELS stress)
  endforeach()
  set_tests_properties(stress.Doors.AServoOnAThreadOfItsOwnUnderSanitizers stress.Doors.AHostileHostUnderSanitizers
                       PROPERTIES LABELS stress)
else()  # from an installation
  typodont_test(bench_doors KIND bench SOURCES bench/doors_bench.cpp LIBS typodont_scene typodont_c fmt::fmt)
  typodont_test(acceptance_doors KIND acceptance SOURCES acceptance/doors_test.cpp
                LIBS fmt::fmt nlohmann_json::nlohmann_json)
  target_compile_definitions(acceptance_doors PRIVATE
    TYPODONT_CMAKE="${CMAKE_COMMAND}" TYPODONT_COMPILER="${CMAKE_CXX_COMPILER}" TYPODONT_CC="${CMAKE_C_COMPILER}"
    TYPODONT_BUILD="${PROJECT_BINARY_DIR}" TYPODONT_LIBDIR="${CMAKE_INSTALL_LIBDIR}"
    TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
  # Tests that need more than a compiler; ./run test installs the tools. A test without its tool is skipped and says
  # what to install.
  find_program(TYPODONT_MCS mcs)
  find_program(TYPODONT_GODOT godot3-server)
  find_program(TYPODONT_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
  foreach(tool MCS GODOT PYTHON)
    if(NOT TYPODONT_${tool})
      set(TYPODONT_${tool} "")
    endif()
    target_compile_definitions(acceptance_doors PRIVATE TYPODONT_${tool}="${TYPODONT_${tool}}")
  endforeach()
  add_dependencies(acceptance_doors typodont typodont_c typodont_openvdb)
endif()
