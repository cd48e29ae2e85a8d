typodont_test(unit_calibration KIND unit SOURCES unit/calibration_registration_test.cpp unit/calibration_bench_test.cpp
          unit/calibration_still_touch_test.cpp unit/calibration_surface_test.cpp
  LIBS typodont_calibration)
typodont_test(property_calibration KIND property
  SOURCES property/calibration_registration_test.cpp property/calibration_delay_test.cpp
          property/calibration_camera_test.cpp property/calibration_hand_eye_test.cpp
  LIBS typodont_calibration Eigen3::Eigen)
typodont_test(acceptance_calibration KIND acceptance SOURCES acceptance/calibration_routine_test.cpp LIBS typodont_calibration)
typodont_test(stress_calibration KIND stress SOURCES stress/calibration_parsers_test.cpp LIBS typodont_calibration)
# Tests of guided capture through the command line.
typodont_test(acceptance_calibration_guide KIND acceptance SOURCES acceptance/calibration_guide_test.cpp LIBS typodont_calibration)
target_compile_definitions(acceptance_calibration_guide PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
add_dependencies(acceptance_calibration_guide typodont)
# Test of the arm step with an emulated arm, in real time.
typodont_test(stress_calibration_live KIND stress SOURCES stress/calibration_live_test.cpp
  LIBS typodont_calibration typodont_devices typodont_device_emulation LIVE)
target_compile_definitions(stress_calibration_live PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
add_dependencies(stress_calibration_live typodont)
# Tests of the commands for building a bench.
typodont_test(acceptance_bench KIND acceptance SOURCES acceptance/bench_commands_test.cpp
  LIBS typodont_calibration typodont_display)
target_compile_definitions(acceptance_bench PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
add_dependencies(acceptance_bench typodont)
