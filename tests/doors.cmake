# The doors (engine/bindings), from an installation: what sanitizers add to a library its users would need, too.
if(NOT TYPODONT_SANITIZE)
  typodont_test(bench_doors KIND bench SOURCES bench/doors_bench.cpp LIBS typodont_scene typodont_c fmt::fmt)
  typodont_test(acceptance_doors KIND acceptance SOURCES acceptance/doors_test.cpp
                LIBS fmt::fmt nlohmann_json::nlohmann_json)
  target_compile_definitions(acceptance_doors PRIVATE
    TYPODONT_CMAKE="${CMAKE_COMMAND}" TYPODONT_COMPILER="${CMAKE_CXX_COMPILER}" TYPODONT_CC="${CMAKE_C_COMPILER}"
    TYPODONT_BUILD="${PROJECT_BINARY_DIR}" TYPODONT_LIBDIR="${CMAKE_INSTALL_LIBDIR}"
    TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
  # What needs more than a compiler is tested where that is installed, as ./run test does.
  find_program(TYPODONT_MCS mcs)
  if(TYPODONT_MCS)
    target_compile_definitions(acceptance_doors PRIVATE TYPODONT_MCS="${TYPODONT_MCS}")
  else()
    message(WARNING "no C# compiler (apt install mono-mcs mono-runtime): C# is not tested")
  endif()
  find_program(TYPODONT_GODOT godot3-server)
  if(TYPODONT_GODOT)
    target_compile_definitions(acceptance_doors PRIVATE TYPODONT_GODOT="${TYPODONT_GODOT}")
  else()
    message(WARNING "no Godot (apt install godot3-server): its plugin is not tested")
  endif()
  find_program(TYPODONT_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
  target_compile_definitions(acceptance_doors PRIVATE TYPODONT_PYTHON="${TYPODONT_PYTHON}")
  execute_process(COMMAND ${TYPODONT_PYTHON} -c "import setuptools, wheel, pip, cffi, numpy" RESULT_VARIABLE no_cffi
                  OUTPUT_QUIET ERROR_QUIET)
  if(no_cffi EQUAL 0)
    target_compile_definitions(acceptance_doors PRIVATE TYPODONT_CFFI)
  else()
    message(WARNING "no cffi, NumPy, pip or wheel (apt install python3-cffi python3-numpy python3-pip python3-setuptools python3-wheel): Python is not tested")
  endif()
  add_dependencies(acceptance_doors typodont typodont_c typodont_volume_reader)
endif()
