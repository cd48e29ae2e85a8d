typodont_test(unit_debris KIND unit SOURCES unit/debris_test.cpp unit/film_test.cpp LIBS typodont_debris)
