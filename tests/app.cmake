typodont_test(unit_app_looks KIND unit SOURCES unit/app_looks_test.cpp LIBS typodont_app)
typodont_test(acceptance_app KIND acceptance SOURCES acceptance/app_servo_test.cpp acceptance/app_bad_input_test.cpp
              acceptance/app_feel_test.cpp acceptance/app_damage_test.cpp acceptance/app_expert_test.cpp
              acceptance/app_bench_test.cpp acceptance/app_undo_test.cpp
              LIBS typodont_app)
typodont_test(acceptance_contact KIND acceptance SOURCES acceptance/app_contact_test.cpp LIBS typodont_app)
typodont_test(acceptance_demo KIND acceptance SOURCES acceptance/app_demo_test.cpp LIBS typodont_app SERIAL TIMEOUT 900)
typodont_test(acceptance_tasks KIND acceptance SOURCES acceptance/app_tasks_test.cpp LIBS typodont_app)
typodont_test(acceptance_work KIND acceptance SOURCES acceptance/nothing_in_vain_test.cpp LIBS typodont_base SERIAL)
foreach(target acceptance_app acceptance_contact acceptance_tasks acceptance_demo acceptance_work)
  target_compile_definitions(${target} PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
  add_dependencies(${target} typodont)
endforeach()
if(TYPODONT_WINDOW)
  typodont_test(unit_operator KIND unit SOURCES unit/operator_steps_test.cpp unit/operator_exercise_test.cpp unit/stroke_book_test.cpp LIBS typodont_app)
  typodont_test(acceptance_operator KIND acceptance SOURCES acceptance/app_operator_test.cpp LIBS typodont_render SERIAL)
  target_compile_definitions(acceptance_operator PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
  add_dependencies(acceptance_operator typodont)
endif()
if(NOT TYPODONT_SANITIZE)  # a sanitizer's shadow needs all the address space
  typodont_test(stress_program KIND stress SOURCES stress/program_exhaustion_test.cpp stress/program_stall_test.cpp
                stress/program_length_test.cpp stress/program_kill_test.cpp LIBS typodont_session)
  target_compile_definitions(stress_program PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
  add_dependencies(stress_program typodont)
endif()
typodont_test(unit_app_live_picture KIND unit SOURCES unit/app_live_picture_test.cpp LIBS typodont_app)
