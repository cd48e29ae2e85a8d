typodont_test(unit_debris KIND unit SOURCES unit/debris_test.cpp unit/film_test.cpp LIBS typodont_debris)
typodont_test(bench_debris KIND bench SOURCES bench/debris_bench.cpp LIBS typodont_debris)
