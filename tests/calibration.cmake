typodont_test(unit_calibration KIND unit SOURCES unit/calibration_registration_test.cpp LIBS typodont_calibration)
typodont_test(property_calibration KIND property SOURCES property/calibration_registration_test.cpp property/calibration_delay_test.cpp
  LIBS typodont_calibration Eigen3::Eigen)
