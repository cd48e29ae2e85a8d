typodont_test(unit_session KIND unit
              SOURCES unit/session_recorder_test.cpp unit/session_ticks_csv_test.cpp unit/session_score_test.cpp
                      unit/session_report_test.cpp unit/session_cavity_test.cpp unit/session_explore_test.cpp unit/session_heat_test.cpp
                      unit/session_hostile_test.cpp unit/session_journal_test.cpp
              LIBS typodont_session typodont_hdf5)
typodont_test(property_session KIND property
              SOURCES property/session_score_property_test.cpp property/session_file_property_test.cpp
                      property/session_cavity_property_test.cpp
              LIBS typodont_session)
typodont_test(stress_session KIND stress SOURCES stress/session_crash_test.cpp LIBS typodont_session)
# A separate program, because it replaces file functions of the C library.
typodont_test(stress_power_cut KIND stress SOURCES stress/session_power_cut_test.cpp LIBS typodont_session)
find_program(TYPODONT_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)  # the one that has Debian's h5py
find_program(TYPODONT_H5DUMP h5dump REQUIRED)
typodont_test(golden_session KIND golden SOURCES golden/session_elsewhere_test.cpp LIBS typodont_session)
target_compile_definitions(golden_session PRIVATE TYPODONT_PYTHON="${TYPODONT_PYTHON}" TYPODONT_H5DUMP="${TYPODONT_H5DUMP}")
# R with hdf5r is large, so this test runs only where it is installed.
find_program(TYPODONT_RSCRIPT Rscript)
if(TYPODONT_RSCRIPT)
  execute_process(COMMAND ${TYPODONT_RSCRIPT} -e "library(hdf5r)" RESULT_VARIABLE no_hdf5r OUTPUT_QUIET ERROR_QUIET)
endif()
if(TYPODONT_RSCRIPT AND no_hdf5r EQUAL 0)
  target_compile_definitions(golden_session PRIVATE TYPODONT_RSCRIPT="${TYPODONT_RSCRIPT}")
else()
  message(WARNING "no R with hdf5r (apt install r-cran-hdf5r): the documented R example is not tested")
endif()
typodont_test(unit_signature KIND unit SOURCES unit/session_signature_test.cpp LIBS typodont_session)
typodont_test(acceptance_sign KIND acceptance SOURCES acceptance/sign_command_test.cpp LIBS typodont_base)
target_compile_definitions(acceptance_sign PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
add_dependencies(acceptance_sign typodont)
typodont_test(acceptance_session KIND acceptance SOURCES acceptance/session_commands_test.cpp LIBS typodont_session)
target_compile_definitions(acceptance_session PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>"
  $<$<BOOL:${TYPODONT_WINDOW}>:TYPODONT_WINDOW>)  # then the program also has libraries of the desktop
add_dependencies(acceptance_session typodont)
# Test of the report in a real browser. ./run test installs one; without a browser the test says so.
find_program(TYPODONT_BROWSER NAMES chromium-headless-shell)
if(TYPODONT_BROWSER)
  typodont_test(acceptance_browser KIND acceptance SOURCES acceptance/session_browser_test.cpp LIBS typodont_session)
  target_compile_definitions(acceptance_browser PRIVATE TYPODONT_BROWSER="${TYPODONT_BROWSER}"
                             TYPODONT_PAGE_CHECK="${CMAKE_CURRENT_SOURCE_DIR}/acceptance/page_accessibility.py")
else()
  message(WARNING "no chromium-headless-shell: the report is not tested in a browser")
endif()
