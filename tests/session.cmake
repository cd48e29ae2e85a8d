typodont_test(unit_session KIND unit SOURCES unit/session_recorder_test.cpp LIBS typodont_session)
typodont_test(stress_session KIND stress SOURCES stress/session_crash_test.cpp LIBS typodont_session)
