# The doors (engine/bindings), from an installation: what sanitizers add to a library its users would need, too.
if(NOT TYPODONT_SANITIZE)
  typodont_test(bench_doors KIND bench SOURCES bench/doors_bench.cpp LIBS typodont_scene typodont_c fmt::fmt)
  typodont_test(acceptance_doors KIND acceptance SOURCES acceptance/doors_test.cpp
                LIBS fmt::fmt nlohmann_json::nlohmann_json)
  target_compile_definitions(acceptance_doors PRIVATE
    TYPODONT_CMAKE="${CMAKE_COMMAND}" TYPODONT_COMPILER="${CMAKE_CXX_COMPILER}" TYPODONT_CC="${CMAKE_C_COMPILER}"
    TYPODONT_BUILD="${PROJECT_BINARY_DIR}" TYPODONT_LIBDIR="${CMAKE_INSTALL_LIBDIR}"
    TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
  # What needs more than a compiler; ./run test installs it. A test without its tool is skipped and says what to install.
  find_program(TYPODONT_MCS mcs)
  find_program(TYPODONT_GODOT godot3-server)
  find_program(TYPODONT_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
  foreach(tool MCS GODOT PYTHON)
    if(NOT TYPODONT_${tool})
      set(TYPODONT_${tool} "")
    endif()
    target_compile_definitions(acceptance_doors PRIVATE TYPODONT_${tool}="${TYPODONT_${tool}}")
  endforeach()
  add_dependencies(acceptance_doors typodont typodont_c typodont_volume_reader)
endif()
