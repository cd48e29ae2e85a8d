typodont_test(unit_mesh KIND unit SOURCES unit/mesh_test.cpp LIBS typodont_haptics)
typodont_test(property_vertex KIND property SOURCES property/vertex_cut_test.cpp property/vertex_model_test.cpp LIBS typodont_haptics)
