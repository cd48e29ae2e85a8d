add_library(typodont_test_stage STATIC support/stage.cpp support/picture_difference.cpp support/tooth_mesh.cpp)
target_link_libraries(typodont_test_stage PUBLIC typodont_render typodont_display ${CMAKE_DL_LIBS})

typodont_test(unit_display KIND unit SOURCES unit/display_rig_test.cpp unit/display_rig_plan_test.cpp unit/head_tracker_test.cpp LIBS typodont_display)
typodont_test(property_display KIND property SOURCES property/display_frusta_test.cpp LIBS typodont_display)
typodont_test(unit_render KIND unit SOURCES unit/render_frame_test.cpp unit/render_film_test.cpp unit/render_light_test.cpp unit/render_tissue_test.cpp unit/render_tissue_light_test.cpp
                                            unit/render_mirror_test.cpp unit/render_views_test.cpp unit/render_difference_test.cpp
                                            unit/display_layout_test.cpp unit/display_writing_test.cpp
              LIBS typodont_test_stage)
typodont_test(property_render KIND property SOURCES property/render_ranges_test.cpp property/render_stereo_test.cpp
                                                    property/render_changed_test.cpp
              LIBS typodont_test_stage)
typodont_test(golden_render KIND golden SOURCES golden/render_golden_test.cpp golden/scene_golden_test.cpp
              LIBS typodont_test_stage typodont_app)
if(TYPODONT_WINDOW)
  typodont_test(acceptance_display KIND acceptance SOURCES acceptance/display_window_test.cpp LIBS typodont_test_stage
                WINDOW)
endif()
typodont_test(acceptance_render KIND acceptance SOURCES acceptance/render_command_test.cpp LIBS typodont_test_stage)
target_compile_definitions(acceptance_render PRIVATE TYPODONT_PROGRAM="$<TARGET_FILE:typodont>")
add_dependencies(acceptance_render typodont)
typodont_test(property_debris_gpu KIND property SOURCES property/debris_gpu_test.cpp LIBS typodont_test_stage typodont_app)
