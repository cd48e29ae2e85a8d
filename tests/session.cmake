typodont_test(unit_session KIND unit SOURCES unit/session_recorder_test.cpp LIBS typodont_session)
