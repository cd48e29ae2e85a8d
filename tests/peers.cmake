# Programs of others beside ours (tests/peers/README.md), where they are installed.
find_package(chai3d CONFIG QUIET)
if(chai3d_FOUND)
  add_executable(peers_chai3d peers/chai3d_slide.cpp)
  target_compile_definitions(peers_chai3d PRIVATE LINUX)  # its headers ask for it
  target_include_directories(peers_chai3d SYSTEM PRIVATE ${CHAI3D_INCLUDE_DIRS})
  target_link_directories(peers_chai3d PRIVATE ${CHAI3D_LIBRARY_DIRS})
  target_link_libraries(peers_chai3d PRIVATE typodont_options typodont_haptics ${CHAI3D_LIBRARIES})
  set_target_properties(peers_chai3d PROPERTIES EXCLUDE_FROM_ALL ON)
else()
  add_custom_target(peers_chai3d VERBATIM COMMAND ${CMAKE_COMMAND} -E echo
                    "no CHAI3D is found here: it adds no rows. Set chai3d_DIR to the folder of chai3dConfig.cmake.")
endif()
