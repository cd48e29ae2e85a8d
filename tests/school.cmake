# Tests of the school's service (engine/school). Not with sanitizers: the service is Python.
if(NOT TYPODONT_SANITIZE AND TARGET typodont)
  find_program(TYPODONT_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)  # the one that has Debian's Django
  find_program(TYPODONT_BROWSER NAMES chromium-headless-shell)
  set(pages)
  if(TYPODONT_BROWSER)
    set(pages pages)
  else()
    message(WARNING "no chromium-headless-shell: the pages of the school are not tested in a browser")
  endif()
  foreach(module roles hand_in bench films exam standards ${pages})
    add_test(NAME acceptance.School.${module}
             COMMAND ${TYPODONT_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/school/run.py $<TARGET_FILE:typodont> test_${module})
    set_tests_properties(acceptance.School.${module} PROPERTIES LABELS acceptance TIMEOUT 1800 COST 20)
  endforeach()
endif()
