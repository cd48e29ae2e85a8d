typodont_test(unit_session KIND unit
              SOURCES unit/session_recorder_test.cpp unit/session_ticks_csv_test.cpp unit/session_score_test.cpp
                      unit/session_report_test.cpp
              LIBS typodont_session)
typodont_test(property_session KIND property
              SOURCES property/session_score_property_test.cpp property/session_file_property_test.cpp
              LIBS typodont_session)
typodont_test(stress_session KIND stress SOURCES stress/session_crash_test.cpp LIBS typodont_session)
