typodont_test(unit_calibration KIND unit SOURCES unit/calibration_registration_test.cpp unit/calibration_bench_test.cpp
  LIBS typodont_calibration)
typodont_test(property_calibration KIND property
  SOURCES property/calibration_registration_test.cpp property/calibration_delay_test.cpp
          property/calibration_camera_test.cpp
  LIBS typodont_calibration Eigen3::Eigen)
typodont_test(acceptance_calibration KIND acceptance SOURCES acceptance/calibration_routine_test.cpp LIBS typodont_calibration)
typodont_test(bench_calibration KIND bench SOURCES bench/calibration_bench_test.cpp LIBS typodont_calibration SERIAL)
typodont_test(stress_calibration KIND stress SOURCES stress/calibration_parsers_test.cpp LIBS typodont_calibration)
