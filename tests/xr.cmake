typodont_test(unit_xr KIND unit SOURCES unit/xr_hand_test.cpp LIBS typodont_app)
if(TYPODONT_OPENXR)
  typodont_test(golden_xr KIND golden SOURCES golden/xr_golden_test.cpp LIBS typodont_test_stage typodont_app)
  typodont_test(stress_xr KIND stress SOURCES stress/xr_states_test.cpp LIBS typodont_test_stage typodont_app)
  typodont_test(acceptance_xr KIND acceptance SOURCES acceptance/xr_run_test.cpp LIBS typodont_session SERIAL)
  foreach(target golden_xr stress_xr acceptance_xr)
    target_compile_definitions(${target} PRIVATE
      TYPODONT_XR_RUNTIME="${CMAKE_BINARY_DIR}/tests/support/xr_runtime/runtime.json"
      TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
    add_dependencies(${target} typodont_xr_runtime typodont)
  endforeach()
endif()
