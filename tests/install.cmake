# Tests of the installed libraries. Not with sanitizers, because users would then need their runtimes, too.
if(NOT TYPODONT_SANITIZE)
  typodont_test(acceptance_consumer KIND acceptance SOURCES acceptance/consumer_test.cpp LIBS fmt::fmt)
  target_compile_definitions(acceptance_consumer PRIVATE
    TYPODONT_CMAKE="${CMAKE_COMMAND}" TYPODONT_COMPILER="${CMAKE_CXX_COMPILER}" TYPODONT_BUILD="${PROJECT_BINARY_DIR}"
    TYPODONT_SOURCE="${PROJECT_SOURCE_DIR}" TYPODONT_PACKAGE="${CMAKE_INSTALL_LIBDIR}/cmake/Typodont")
  add_dependencies(acceptance_consumer typodont_haptics typodont_devices typodont_import typodont_audio typodont_calibration)
endif()
