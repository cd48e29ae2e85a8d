typodont_test(unit_app_looks KIND unit SOURCES unit/app_looks_test.cpp LIBS typodont_app)
typodont_test(acceptance_app KIND acceptance SOURCES acceptance/app_servo_test.cpp acceptance/app_bad_input_test.cpp
              acceptance/app_feel_test.cpp
              acceptance/app_bench_test.cpp
              LIBS typodont_app)
typodont_test(acceptance_demo KIND acceptance SOURCES acceptance/app_demo_test.cpp LIBS typodont_app SERIAL TIMEOUT 900)
typodont_test(acceptance_tasks KIND acceptance SOURCES acceptance/app_tasks_test.cpp LIBS typodont_app)
foreach(target acceptance_app acceptance_tasks acceptance_demo)
  target_compile_definitions(${target} PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
  add_dependencies(${target} typodont)
endforeach()
typodont_test(stress_program KIND stress SOURCES stress/program_exhaustion_test.cpp)
target_compile_definitions(stress_program PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
add_dependencies(stress_program typodont)
