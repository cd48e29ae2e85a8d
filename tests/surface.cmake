add_library(typodont_surface_checks STATIC support/surface_checks.cpp)
target_link_libraries(typodont_surface_checks PUBLIC typodont_surface)
typodont_test(unit_surface KIND unit SOURCES unit/surface_export_test.cpp
              LIBS typodont_surface_checks)
typodont_test(property_surface KIND property SOURCES property/surface_mesh_test.cpp property/surface_incremental_test.cpp
              LIBS typodont_surface_checks)
typodont_test(acceptance_surface KIND acceptance SOURCES acceptance/surface_mesh_command_test.cpp
              LIBS typodont_surface_checks)
target_compile_definitions(acceptance_surface PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
add_dependencies(acceptance_surface typodont)
