typodont_test(unit_base KIND unit SOURCES unit/base_test.cpp unit/latest_test.cpp unit/progress_test.cpp unit/include_graph_test.cpp unit/readme_test.cpp LIBS typodont_base typodont_contract)
