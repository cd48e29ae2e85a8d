add_library(typodont_test_tissues STATIC support/reference_contact.cpp support/model_tissues.cpp)
target_link_libraries(typodont_test_tissues PUBLIC typodont_haptics)
typodont_test(unit_haptics KIND unit SOURCES unit/haptics_contact_test.cpp unit/haptics_shapes_test.cpp unit/haptics_cutting_test.cpp unit/haptics_chips_test.cpp unit/haptics_wear_test.cpp unit/haptics_tools_test.cpp
              unit/haptics_fill_test.cpp unit/haptics_shank_test.cpp unit/haptics_vibration_test.cpp unit/haptics_patch_test.cpp
              unit/haptics_model_test.cpp unit/haptics_soft_test.cpp unit/haptics_hardness_test.cpp unit/haptics_color_test.cpp unit/haptics_retreat_test.cpp unit/haptics_teeth_test.cpp unit/haptics_turn_test.cpp support/ball_model.cpp
              LIBS typodont_test_tissues)
# the only test program with OpenVDB
typodont_test(unit_volumes KIND unit SOURCES unit/haptics_block_grid_test.cpp unit/haptics_vdb_guard_test.cpp
              LIBS typodont_haptics OpenVDB::openvdb TBB::tbb)
target_compile_options(unit_volumes PRIVATE -Wno-conversion -Wno-shadow -Wno-pedantic)
typodont_test(property_haptics KIND property SOURCES property/haptics_passivity_test.cpp property/haptics_laws_test.cpp property/haptics_soft_test.cpp property/haptics_undo_test.cpp property/haptics_sampling_test.cpp property/haptics_sweeps_test.cpp property/haptics_pieces_test.cpp property/haptics_creases_test.cpp property/haptics_smooth_test.cpp property/haptics_intermediate_test.cpp property/contact_cases_test.cpp
              LIBS typodont_haptics)
typodont_test(stress_haptics KIND stress SOURCES stress/haptics_hostile_test.cpp stress/haptics_soft_test.cpp stress/haptics_campaign_test.cpp stress/model_hostile_test.cpp LIBS typodont_haptics)
